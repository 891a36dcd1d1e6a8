#include "engine/devices/hapi_link.h"

#include <algorithm>
#include <cmath>

#include "engine/devices/monotonic_clock.h"
#include "haptics/safety_governor.h"

namespace palpate {
namespace {

// An older command of the haptic thread does not count. period_ns: of the slower of the ticks and
// the messages, because a tick that is on time must not find its force cut.
std::int64_t oldest_command_ns(std::int64_t period_ns) {
  return std::max(std::llround(GovernorLimits::kStale_s * kSecond_ns),
                  std::llround(GovernorLimits::kStalePeriods * static_cast<double>(period_ns)));
}

// False if a joint would have turned faster than any hand turns it.
bool can_turn(const HapiNumbers& from_deg, const HapiNumbers& to_deg, std::int64_t time_ns) {
  const double most_deg =
      HapiLink::kFastestJoint_deg_per_s / kSecond_ns * static_cast<double>(time_ns);
  for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
    const float turn_deg = to_deg[joint] - from_deg[joint];
    if (std::abs(static_cast<double>(turn_deg)) > most_deg) return false;
  }
  return true;
}

}  // namespace

HapiLink::HapiLink(const HapiSettings& settings)
    : settings_(settings),
      bar_(settings.links),
      torques_(settings_),
      angles_deg_(settings.wiring.rest_deg),
      parser_(settings.wiring.device, angles_deg_),
      period_ns_(std::llround(kSecond_ns / settings.rate_Hz)),
      exchanges_(period_ns_) {}

void HapiLink::start(std::int64_t now_ns) {
  begin_clearing(now_ns);
}

void HapiLink::set_guard(WriteGuard* guard) {
  guard_ = guard;
  if (guard_ != nullptr) guard_epoch_ = guard_->trip_epoch();
}

void HapiLink::set_force(const HapiForce& force) {
  force_ = force;
  const bool is_zero = force.force_N == std::array<double, 2>{};
  if (is_zero && force.tick_ns > trip_ns_) awaits_zero_ = false;
}

void HapiLink::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  for (const std::uint8_t byte : bytes) {
    if (phase_ == Phase::kClearing) quiet_since_ns_ = now_ns;
    if (phase_ == Phase::kClearing || phase_ == Phase::kOff) continue;
    const bool is_asking = phase_ == Phase::kAsking;
    // The next message would cut a question that the line has not taken yet.
    if (is_asking && !to_send().empty()) continue;
    switch (parser_.add(byte)) {
      case HapiAnswerParser::State::kIncomplete:
        break;
      case HapiAnswerParser::State::kComplete:
        is_asking ? take_angles(now_ns) : take_answer(now_ns);
        break;
      case HapiAnswerParser::State::kMalformed:
        is_asking ? set_up(now_ns) : refuse_answer(now_ns);
        break;
    }
  }
}

void HapiLink::take_answer(std::int64_t now_ns) {
  if (flights_.is_empty()) {  // nobody waits for it any more
    ++counts_.late;
    return;
  }
  const auto pose = hapi_pose(bar_, parser_.angles_deg());
  const bool is_first = !pose_;
  if (!pose ||
      !(is_first || can_turn(angles_deg_, parser_.angles_deg(), now_ns - sample_.time_ns))) {
    refuse_answer(now_ns);
    return;
  }
  const HapiFlights::Flight flight = flights_.take();
  angles_deg_ = parser_.angles_deg();
  const std::int64_t age_ns = now_ns - flight.sent_ns;
  round_trips_.add(age_ns);
  exchanges_.add(flight.sent_ns, now_ns);
  ++counts_.answers;
  pose_ = pose;
  sample_.tip_m = {pose->tip_m.x(), pose->tip_m.y()};
  const Mat2& j = pose->jacobian;
  sample_.jacobian = {j(0, 0), j(0, 1), j(1, 0), j(1, 1)};
  sample_.fade = pose->fade;
  sample_.sequence = counts_.answers;
  sample_.time_ns = flight.sent_ns;
  if (age_ns > kAnswer_ns) {
    ++counts_.late;
    if (!flight.is_missed) count_bad(HapiProblem::kNoAnswers, now_ns);
    return;
  }
  bad_in_a_row_ = 0;
  if (is_guard_gone_) return;
  sample_.is_working = true;
  if (owes_acknowledgement_) guard_->acknowledge(guard_epoch_);
  owes_acknowledgement_ = false;
}

void HapiLink::refuse_answer(std::int64_t now_ns) {
  ++counts_.malformed;
  count_bad(HapiProblem::kBadAnswers, now_ns);
  begin_clearing(now_ns);
}

void HapiLink::count_bad(HapiProblem problem, std::int64_t now_ns) {
  if (++bad_in_a_row_ < kMostBad) return;
  bad_in_a_row_ = 0;
  trip(problem, now_ns);
  begin_clearing(now_ns);
}

void HapiLink::trip(HapiProblem problem, std::int64_t now_ns) {
  trip_ns_ = now_ns;
  awaits_zero_ = true;
  if (!sample_.is_working) return;
  sample_.is_working = false;
  sample_.problem = problem;
  ++sample_.trips;
}

void HapiLink::hang_up(std::int64_t now_ns) {
  if (phase_ == Phase::kOff) return;
  trip(HapiProblem::kHungUp, now_ns);
  phase_ = Phase::kOff;
  outgoing_.clear();
  sent_ = 0;
}

void HapiLink::step(std::int64_t now_ns) {
  if (phase_ == Phase::kOff) return;
  watch_guard(now_ns);
  watch_answers(now_ns);
  if (phase_ != Phase::kRunning) watch_clearing(now_ns);
  if (phase_ != Phase::kRunning) return;
  const bool has_begun = sent_ > 0 || !is_tick_;
  const bool waits = !to_send().empty();
  if (waits && !has_begun) {
    make_tick(now_ns);  // anew, with the newest force
  } else if (!waits && may_send() && now_ns >= next_tick_ns_) {
    if (flights_.is_full()) flights_.take();
    flights_.add(now_ns);
    count_message(now_ns);
    make_tick(now_ns);
    // The messages keep their rhythm unless one was late by a period.
    const bool is_in_rhythm = now_ns - next_tick_ns_ < period_ns_;
    next_tick_ns_ = (is_in_rhythm ? next_tick_ns_ : now_ns) + period_ns_;
  }
}

void HapiLink::watch_guard(std::int64_t now_ns) {
  if (guard_ == nullptr || is_guard_gone_) return;
  const GuardState state = guard_->state(now_ns);
  if (state != GuardState::kAlive) {
    is_guard_gone_ = true;
    trip(state == GuardState::kFrozen ? HapiProblem::kGuardFrozen : HapiProblem::kGuardGone,
         now_ns);
    return;
  }
  const std::uint64_t epoch = guard_->trip_epoch();
  if (epoch == guard_epoch_) return;
  guard_epoch_ = epoch;
  owes_acknowledgement_ = true;
  trip(guard_->was_suspended() ? HapiProblem::kSuspended : HapiProblem::kGuardTripped, now_ns);
  begin_clearing(now_ns);
}

void HapiLink::watch_answers(std::int64_t now_ns) {
  if (phase_ != Phase::kRunning || flights_.is_empty()) return;
  HapiFlights::Flight& newest = flights_.newest();
  const std::int64_t age_ns = now_ns - newest.sent_ns;
  if (flights_.is_newest_met()) {
    if (age_ns >= kForget_ns) flights_.clear();
    return;
  }
  if (newest.is_missed || age_ns < kAnswer_ns) return;
  if (parser_.has_part()) {
    refuse_answer(now_ns);
    return;
  }
  // The message of a line that takes no bytes stays in flight, and each wait for it counts.
  const bool is_stuck = !to_send().empty();
  newest.is_missed = !is_stuck;
  if (is_stuck) newest.sent_ns = now_ns;
  ++counts_.missed;
  count_bad(HapiProblem::kNoAnswers, now_ns);
}

// Only one message is in flight, unless its answer is overdue.
bool HapiLink::may_send() const {
  return flights_.is_empty() || (flights_.newest().is_missed && !flights_.is_newest_met());
}

void HapiLink::begin_clearing(std::int64_t now_ns) {
  phase_ = Phase::kClearing;
  quiet_since_ns_ = clearing_since_ns_ = now_ns;
  flights_.clear();
  parser_ = HapiAnswerParser(settings_.wiring.device, angles_deg_);
  first_asked_deg_.reset();
  torques_.confirm_zero();
  put(hapi_stop_bytes(settings_.wiring));
  is_tick_ = false;
  is_zero_ = true;
}

void HapiLink::watch_clearing(std::int64_t now_ns) {
  const bool is_long = now_ns - clearing_since_ns_ >= kLongestClearing_ns;
  const std::int64_t quiet_ns = now_ns - quiet_since_ns_;
  if (!to_send().empty()) {  // the line takes no bytes
    if (!is_long) return;
    trip(HapiProblem::kNoAnswers, now_ns);
    begin_clearing(now_ns);
  } else if (guard_ != nullptr && !is_guard_gone_ && !guard_->is_quiet()) {
    quiet_since_ns_ = clearing_since_ns_ = now_ns;  // its zeros would undo a set-up
  } else if (phase_ == Phase::kAsking) {
    if (quiet_ns >= kAnswer_ns) set_up(now_ns);
  } else if (is_long || quiet_ns >= kForget_ns) {
    // Before the first set-up, the board has no angles.
    counts_.set_ups > 0 ? ask_for_angles(now_ns) : set_up(now_ns);
  }
}

// A set-up makes the present pose the angles that it states. The hand has moved since the last good
// answer.
void HapiLink::ask_for_angles(std::int64_t now_ns) {
  phase_ = Phase::kAsking;
  quiet_since_ns_ = now_ns;
  put(hapi_tick(settings_.wiring.device, {}));
  is_zero_ = true;
}

// A wrong angle would stay wrong. Therefore two answers must agree.
void HapiLink::take_angles(std::int64_t now_ns) {
  const HapiNumbers angles_deg = parser_.angles_deg();
  if (!first_asked_deg_) {
    first_asked_deg_ = angles_deg;
    first_asked_ns_ = now_ns;
    ask_for_angles(now_ns);
    return;
  }
  const bool is_good = can_turn(*first_asked_deg_, angles_deg, now_ns - first_asked_ns_) &&
                       can_turn(angles_deg_, angles_deg, now_ns - sample_.time_ns);
  if (is_good && hapi_pose(bar_, angles_deg)) angles_deg_ = angles_deg;
  set_up(now_ns);
}

void HapiLink::set_up(std::int64_t now_ns) {
  parser_ = HapiAnswerParser(settings_.wiring.device, angles_deg_);
  put(hapi_reset());
  const auto message = hapi_set_up(settings_.wiring, angles_deg_);
  outgoing_.insert(outgoing_.end(), message.begin(), message.end());
  is_tick_ = is_zero_ = false;
  phase_ = Phase::kRunning;
  next_tick_ns_ = last_tick_ns_ = now_ns;
  ++counts_.set_ups;
}

void HapiLink::count_message(std::int64_t now_ns) {
  if (counts_.messages == 0) first_message_ns_ = second_since_ns_ = now_ns;
  if (now_ns - second_since_ns_ >= kSecond_ns) {
    const std::uint64_t messages = counts_.messages - messages_before_second_;
    const bool is_first = messages_before_second_ == 0;
    counts_.fewest_in_second = is_first ? messages : std::min(counts_.fewest_in_second, messages);
    messages_before_second_ = counts_.messages;
    second_since_ns_ = now_ns;
  }
  ++counts_.messages;
  counts_.messages_ns = now_ns - first_message_ns_;
}

void HapiLink::make_tick(std::int64_t now_ns) {
  const bool has_force = commands_force(now_ns);
  const Vec2 force_N = has_force ? Vec2(force_.force_N.data()) : Vec2::Zero();
  answered_sample_ns_ = has_force ? force_.sample_ns : 0;
  const HapiNumbers torques =
      torques_.next(force_N, pose_.value_or(HapiPose{}), now_ns - last_tick_ns_);
  put(hapi_tick(settings_.wiring.device, torques));
  is_tick_ = true;
  is_zero_ = torques == HapiNumbers{};
}

bool HapiLink::commands_force(std::int64_t now_ns) const {
  if (is_released_ || awaits_zero_ || !sample_.is_working || !pose_) return false;
  if (is_guard_gone_ || (guard_ == nullptr && !settings_.works_without_guard)) return false;
  if (force_.tick_ns == 0) return false;
  const std::int64_t period_ns = std::max(period_ns_, force_.period_ns);
  return now_ns - force_.tick_ns <= oldest_command_ns(period_ns);
}

template <typename Message>
void HapiLink::put(const Message& message) {
  outgoing_.assign(message.begin(), message.end());
  sent_ = 0;
}

void HapiLink::sent(std::size_t count, std::int64_t now_ns) {
  if (count == 0) return;
  sent_ = std::min(sent_ + count, outgoing_.size());
  if (!to_send().empty()) return;
  if (phase_ != Phase::kRunning) quiet_since_ns_ = now_ns;
  // Before the first tick, no force can be old.
  if (guard_ != nullptr) guard_->beat(force_.tick_ns != 0 ? force_.tick_ns : now_ns, now_ns);
  if (!is_tick_ && !is_zero_) return;  // a set-up
  has_sent_zero_ = is_released_ && is_zero_;
  if (!is_tick_) return;
  torques_.confirm();
  last_tick_ns_ = now_ns;
  count_delay(now_ns);
}

void HapiLink::count_delay(std::int64_t now_ns) {
  if (answered_sample_ns_ == 0 || is_zero_) return;
  const std::int64_t delay_ns = now_ns - answered_sample_ns_;
  delays_.add(delay_ns);
  ++counts_.forces;
  if (delay_ns > longest_delay_ns_) ++counts_.delayed_forces;
}

std::int64_t HapiLink::wake_ns() const {
  if (phase_ != Phase::kRunning) {
    if (!to_send().empty()) return clearing_since_ns_ + kLongestClearing_ns;
    return quiet_since_ns_ + (phase_ == Phase::kAsking ? kAnswer_ns : kForget_ns);
  }
  if (may_send() && to_send().empty()) return next_tick_ns_;
  if (flights_.is_empty()) return next_tick_ns_;
  return flights_.newest().sent_ns + (flights_.is_newest_met() ? kForget_ns : kAnswer_ns);
}

HapiCounts HapiLink::counts() const {
  HapiCounts counts = counts_;
  counts.round_trip_median_ns = round_trips_.median_ns();
  counts.round_trip_longest_ns = round_trips_.longest_ns();
  counts.delay_median_ns = delays_.median_ns();
  counts.delay_longest_ns = delays_.longest_ns();
  return counts;
}

}  // namespace palpate
