// libFuzzer's target: the bytes are a script of a conversation with a hAPI board, in virtual time.
// The board sends any bytes in any chunks at any times, the line takes any number of bytes, and
// forces, trips of the guard and a hang-up come in between. PRESET=fuzz ./test.sh runs the target.
//
// What must hold: an answer counts only if its bytes are a whole, well-formed one; the chunks of
// the bytes change nothing; the counters agree with the bytes and the time that there were; the
// driver's thread always has something to wait for; the board never gets a torque above the peak,
// nor any torque after a trip, without a fresh tick or without a guard.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "engine/devices/hapi_link.h"
#include "engine/simulation/hapi_firmware.h"
#include "tests/engine/devices/hapi_rig.h"

namespace palpate {
namespace {

using test::FakeGuard;
using test::kMillisecond_ns;
using Bytes = std::span<const std::uint8_t>;

constexpr std::int64_t kStart_ns = 1'000 * kMillisecond_ns;
// hapi_stop_bytes() is the longest message of a running link: a set-up and a tick.
constexpr std::size_t kMostBytes = 64;
// A torque below this is a zero whose first byte the padding of hapi_stop_bytes() has replaced.
constexpr double kPadding = 0x1p-119;

void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "fuzz_hapi_link: violated: " << what << "\n";
  std::abort();
}

// The script. Behind its end there are zeros.
class Script {
 public:
  explicit Script(Bytes bytes) : rest_(bytes) {}
  bool is_over() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t first = rest_.front();
    rest_ = rest_.subspan(1);
    return first;
  }
  int small() { return static_cast<std::int8_t>(byte()); }
  Bytes bytes(std::size_t count) {
    const Bytes first = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(first.size());
    return first;
  }

 private:
  Bytes rest_;
};

HapiSettings drawn_settings(Script& script) {
  HapiSettings settings;
  const std::uint8_t choice = script.byte();
  settings.rate_Hz = std::array{1000.0, 50.0, 333.0, 4000.0}[choice & 3];
  settings.wiring.device = static_cast<std::uint8_t>(choice & 4 ? 127 : 5);
  settings.peak_torque_Nm = 0.1;
  if ((choice & 8) == 0) settings.torque_per_Nm = choice & 16 ? -3.0 : 1.0;
  return settings;
}

float number_at(Bytes bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (std::size_t k = 4; k-- > 0;) bits = bits << 8 | bytes[at + k];
  return std::bit_cast<float>(bits);
}

auto fields(const HapiCounts& c) {
  return std::tuple(c.messages, c.answers, c.missed, c.late, c.malformed, c.set_ups,
                    c.round_trip_median_ns, c.round_trip_longest_ns);
}
auto fields(const HapiSample& s) {
  return std::tuple(s.tip_m, s.jacobian, s.fade, s.sequence, s.time_ns, s.is_working, s.trips,
                    s.problem);
}

// The parser alone: it completes an answer after nine bytes with the right device and with angles
// that are within 360 degrees of the last complete answer, refuses the answer at the first byte
// that is wrong, and begins anew after both.
class ParserJudge {
 public:
  explicit ParserJudge(const HapiWiring& wiring)
      : device_(wiring.device), last_deg_(wiring.rest_deg), parser_(device_, last_deg_) {}

  void add(std::uint8_t byte) {
    part_.push_back(byte);
    State expected = State::kIncomplete;
    if (part_[0] != device_) {
      expected = State::kMalformed;
    } else if (part_.size() == kHapiAnswerSize) {
      const HapiNumbers angles_deg = {number_at(part_, 1), number_at(part_, 5)};
      expected = State::kComplete;
      for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
        const bool is_near = std::isfinite(angles_deg[joint]) &&
                             std::abs(angles_deg[joint] - last_deg_[joint]) <= 360.0f;
        if (!is_near) expected = State::kMalformed;
      }
      if (expected == State::kComplete) last_deg_ = angles_deg;
    }
    require(parser_.add(byte) == expected, "the parser takes whole answers and nothing else");
    require(parser_.angles_deg() == last_deg_, "the parser keeps the angles of the last answer");
    if (expected != State::kIncomplete) part_.clear();
    require(parser_.has_part() == !part_.empty(), "the parser begins anew");
  }

 private:
  using State = HapiAnswerParser::State;
  std::uint8_t device_;
  HapiNumbers last_deg_;
  HapiAnswerParser parser_;
  std::vector<std::uint8_t> part_;  // of an answer
};

// The board's bytes that the link has had, and the last answer that it accepted.
class AnswerJudge {
 public:
  explicit AnswerJudge(const HapiSettings& settings) : settings_(settings) {}

  std::uint64_t bytes() const { return bytes_; }

  // The messages before are forgotten.
  void note_set_up(std::int64_t now_ns) { set_up_ns_ = now_ns; }

  // before, after: around this byte.
  void add(std::uint8_t byte, const HapiSample& before, const HapiSample& after,
           std::int64_t now_ns) {
    ++bytes_;
    std::rotate(last_.begin(), last_.begin() + 1, last_.end());
    last_.back() = byte;
    ++unused_;
    require(after.sequence - before.sequence <= 1, "a byte ends at most one answer");
    if (after.sequence == before.sequence) return;
    require(unused_ >= kHapiAnswerSize, "an answer has all of its bytes");
    unused_ = 0;
    require(last_[0] == settings_.wiring.device, "an answer begins with the device");
    require(after.time_ns >= before.time_ns && after.time_ns <= now_ns, "an answer has its time");
    require(after.time_ns >= set_up_ns_, "a message before a set-up has no answer");
    judge_angles(before, after, now_ns);
  }

 private:
  void judge_angles(const HapiSample& before, const HapiSample& after, std::int64_t now_ns) {
    HapiNumbers angles_deg;
    for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
      angles_deg[joint] = number_at(last_, 1 + 4 * joint);
      require(std::isfinite(angles_deg[joint]), "an angle is finite");
      if (before.sequence == 0) continue;
      const double turn_deg = static_cast<double>(angles_deg[joint] - angles_deg_[joint]);
      const double time_s = 1e-9 * static_cast<double>(now_ns - before.time_ns);
      require(std::abs(turn_deg) <= HapiLink::kFastestJoint_deg_per_s * time_s * (1 + 1e-15),
              "a joint turns no faster than a hand turns it");
    }
    angles_deg_ = angles_deg;
    judge_tip(Vec2(after.tip_m.data()));
  }

  // The tip is a distal link away from each elbow. A coordinate is the result of some ten roundings
  // of lengths up to the linkage's reach, and a length of two of them.
  void judge_tip(const Vec2& tip_m) const {
    const FiveBarLinks& links = settings_.links;
    const double reach_m = links.base_m + links.proximal_m + links.distal_m;
    for (std::size_t joint = 0; joint < kHapiJoints; ++joint) {
      const double angle = static_cast<double>(angles_deg_[joint]) * std::acos(-1.0) / 180.0;
      const Vec2 elbow_m = Vec2(joint == 0 ? 0.0 : links.base_m, 0.0) +
                           links.proximal_m * Vec2(std::cos(angle), std::sin(angle));
      require(std::abs((tip_m - elbow_m).norm() - links.distal_m) <=
                  64 * std::numeric_limits<double>::epsilon() * reach_m,
              "the tip follows from the angles");
    }
  }

  const HapiSettings& settings_;
  std::uint64_t bytes_ = 0;
  std::int64_t set_up_ns_ = 0;
  std::size_t unused_ = 0;  // bytes since the last accepted answer
  std::array<std::uint8_t, kHapiAnswerSize> last_{};
  HapiNumbers angles_deg_{};
};

// A link and its guard.
struct Side {
  explicit Side(const HapiSettings& settings) : link(settings) {
    link.set_guard(&guard);
    link.start(kStart_ns);
  }
  FakeGuard guard;
  HapiLink link;
};

class Conversation {
 public:
  explicit Conversation(Script script)
      : script_(script),
        settings_(drawn_settings(script_)),
        whole_(settings_),
        single_(settings_),
        parser_(settings_.wiring),
        answers_(settings_) {}

  void run() {
    exchange();
    while (!script_.is_over()) {
      act();
      exchange();
    }
  }

 private:
  void act() {
    const std::uint8_t action = script_.byte();
    switch (action & 15) {
      case 0:
      case 1:
        now_ns_ += 20'000 * script_.byte();
        break;
      case 2:
        now_ns_ += kMillisecond_ns * script_.byte();
        break;
      case 3:  // to the next step
        now_ns_ = std::max(now_ns_, whole_.link.wake_ns());
        break;
      case 4:
        receive(script_.bytes(script_.byte() % 24u));
        break;
      case 5:
      case 6:
        answer_as_a_board(0);
        break;
      case 7:
        answer_as_a_board(script_.byte());
        break;
      case 8:
      case 9:
        command(action);
        break;
      case 10:
        room_ = script_.byte() % 24u;  // what the line takes at a time
        break;
      case 11:
        room_ = kMostBytes;
        break;
      case 12:
        for (Side* side : {&whole_, &single_}) side->guard.epoch += action >> 4 & 1;
        break;
      case 13:
        pause();
        break;
      default:
        end(action);
    }
  }

  // The firmware's answer, cut in two with time between them, with a changed byte unless mask is 0.
  void answer_as_a_board(std::uint8_t mask) {
    const std::uint8_t where = script_.byte();
    for (double& joint_deg : joints_deg_) joint_deg += 0.05 * script_.small();
    auto bytes = board_.answer(joints_deg_);
    bytes[where / 16 % bytes.size()] ^= mask;
    const std::size_t cut = where % bytes.size();
    receive(Bytes(bytes).first(cut));
    if (where & 128) {
      now_ns_ += 20'000 * script_.byte();
      exchange();
    }
    receive(Bytes(bytes).subspan(cut));
  }

  // One link gets the bytes in one chunk, the other one byte by byte.
  void receive(Bytes bytes) {
    whole_.link.receive(bytes, now_ns_);
    for (const std::uint8_t& byte : bytes) {
      const HapiSample before = single_.link.sample();
      single_.link.receive({&byte, 1}, now_ns_);
      answers_.add(byte, before, single_.link.sample(), now_ns_);
      parser_.add(byte);
      note_changes();
    }
    require_equal_sides();
  }

  void command(std::uint8_t action) {
    HapiForce force{{}, now_ns_};
    if (action & 16) {
      force.force_N = {0.1 * script_.small(), 0.1 * script_.small()};
      if (action & 32) force.force_N[0] = std::numeric_limits<double>::quiet_NaN();
      if (action & 64) force.force_N[1] *= 1e300;
    }
    const bool is_zero = force.force_N[0] == 0.0 && force.force_N[1] == 0.0;
    if (is_zero && now_ns_ > trip_ns_) has_had_zero_ = true;
    tick_ns_ = now_ns_;
    for (Side* side : {&whole_, &single_}) side->link.set_force(force);
  }

  // A stretch of time in which nothing happens but the steps of the driver's thread.
  void pause() {
    for (int steps = script_.byte() % 32; steps > 0; --steps) {
      now_ns_ = std::max(now_ns_ + 10'000, whole_.link.wake_ns());
      exchange();
    }
  }

  // What cannot be undone is rare.
  void end(std::uint8_t action) {
    if (action >> 4 == 1) {
      for (Side* side : {&whole_, &single_}) side->guard.at_present = GuardState::kEnded;
    } else if (action >> 4 == 2) {
      is_released_ = true;
      for (Side* side : {&whole_, &single_}) side->link.release();
    } else if (action >> 4 == 3) {
      for (Side* side : {&whole_, &single_}) side->link.hang_up(now_ns_);
    }
  }

  // What the driver's thread does after it has read.
  void exchange() {
    for (Side* side : {&whole_, &single_}) side->link.step(now_ns_);
    note_changes();
    require_equal_sides();
    judge_message();
    const Bytes out = whole_.link.to_send();
    const Bytes taken = out.first(std::min(out.size(), room_));
    for (const std::uint8_t byte : taken) send(byte);
    const std::size_t count = taken.size();
    for (Side* side : {&whole_, &single_}) side->link.sent(count, now_ns_);
    judge_counts();
    const HapiLink& link = whole_.link;
    // A message that was sent may be followed by the next one at once.
    require(link.is_off() || !link.to_send().empty() || count > 0 || link.wake_ns() > now_ns_,
            "a step does what is due");
  }

  void note_changes() {
    const HapiSample& sample = single_.link.sample();
    if (single_.link.counts().set_ups != set_ups_) answers_.note_set_up(now_ns_);
    set_ups_ = single_.link.counts().set_ups;
    if (sample.trips == trips_) return;
    require(sample.trips == trips_ + 1 && !sample.is_working, "a trip ends the work");
    trips_ = sample.trips;
    trip_ns_ = now_ns_;
    has_had_zero_ = false;
  }

  void require_equal_sides() {
    require(fields(whole_.link.counts()) == fields(single_.link.counts()), "equal counts");
    require(fields(whole_.link.sample()) == fields(single_.link.sample()), "equal samples");
    require(std::ranges::equal(whole_.link.to_send(), single_.link.to_send()), "equal messages");
    require(whole_.link.wake_ns() == single_.link.wake_ns(), "equal times");
  }

  // A tick message that has not begun.
  void judge_message() {
    const Bytes out = whole_.link.to_send();
    require(out.size() <= kMostBytes, "messages do not pile up");
    require(out.empty() || !whole_.link.is_off(), "a dead line gets nothing");
    if (out.size() != kHapiTickSize || out[0] != 2 || out[1] != settings_.wiring.device) return;
    if (number_at(out, 2) == 0.0f && number_at(out, 6) == 0.0f) return;
    const std::int64_t oldest_ns =
        std::max<std::int64_t>(10 * kMillisecond_ns, std::llround(5e9 / settings_.rate_Hz));
    require(whole_.link.sample().is_working && has_had_zero_, "no torque after a trip");
    require(whole_.guard.at_present == GuardState::kAlive, "no torque without a guard");
    require(!is_released_, "no torque after the release");
    require(tick_ns_ != 0 && now_ns_ - tick_ns_ <= oldest_ns, "no torque of an old tick");
  }

  void send(std::uint8_t byte) {
    board_.receive(byte, joints_deg_);
    const double most = std::abs(settings_.torque_per_Nm.value_or(0.0)) * settings_.peak_torque_Nm;
    for (const float torque : board_.torques()) {
      require(std::abs(torque) <= std::max(static_cast<float>(most), static_cast<float>(kPadding)),
              "no torque above the peak");
    }
  }

  void judge_counts() const {
    const HapiCounts counts = whole_.link.counts();
    const HapiSample& sample = whole_.link.sample();
    const std::int64_t time_ns = now_ns_ - kStart_ns;
    const auto fits = [&](std::uint64_t count, std::int64_t each_ns) {
      return static_cast<std::int64_t>(count) * each_ns <= time_ns;
    };
    require(sample.sequence == counts.answers, "answers are numbered");
    require(counts.answers <= counts.messages, "an answer needs a message");
    require(kHapiAnswerSize * counts.answers + counts.malformed <= answers_.bytes(),
            "answers need their bytes");
    require(kHapiAnswerSize * counts.late <= answers_.bytes(), "late answers need their bytes");
    require(fits(counts.missed, HapiLink::kAnswer_ns), "each wait takes its time");
    require(fits(counts.set_ups, HapiLink::kForget_ns), "a set-up needs a quiet line");
    const auto period_ns = std::llround(1e9 / settings_.rate_Hz);
    require(counts.messages <= counts.set_ups || fits(counts.messages - counts.set_ups, period_ns),
            "messages keep their rhythm");
    require(sample.trips <= counts.set_ups, "a trip needs a set-up");
    require(!sample.is_working || counts.answers > 0, "work begins with an answer");
    require(counts.round_trip_median_ns <= counts.round_trip_longest_ns, "a median is in between");
    require(counts.round_trip_longest_ns <= time_ns, "a round trip is in the past");
  }

  Script script_;
  HapiSettings settings_;
  Side whole_;   // gets each chunk of bytes at once
  Side single_;  // gets each byte alone
  ParserJudge parser_;
  AnswerJudge answers_;
  HapiFirmware board_;
  HapiFirmware::Joints joints_deg_ = {180.0, 0.0, 0.0, 0.0};
  std::int64_t now_ns_ = kStart_ns;
  std::size_t room_ = kMostBytes;
  std::int64_t tick_ns_ = 0;  // of the newest force
  std::uint64_t set_ups_ = 0;
  std::uint64_t trips_ = 0;
  std::int64_t trip_ns_ = 0;
  bool has_had_zero_ = true;  // a tick has commanded zero since the last trip
  bool is_released_ = false;
};

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  palpate::Conversation(palpate::Script({data, size})).run();
  return 0;
}
