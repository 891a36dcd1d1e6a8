#include "tests/haptics/governor_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "haptics/nanoseconds.h"
#include "haptics/record_vectors.h"

namespace palpate::test {
namespace {

using Limits = GovernorLimits;

// The motors of a judged device are far from linear dependence: their smallest singular value is at
// least 0.2. A solution of the normal equations then rounds by less than 1e3 epsilon of the force.
constexpr double kJudgeRound = 1e3 * std::numeric_limits<double>::epsilon();
// Sums over a schedule, such as heat and energy, round by an epsilon in each of up to 1e5 ticks.
constexpr double kSumRound = 1e5 * std::numeric_limits<double>::epsilon();
// The fade of the heat: from a mean square of 1 - kHeatFade to 1, a factor falls. A sum's rounding
// counts that much more there.
constexpr double kHeatFade = 1.0 - 0.98 * 0.98;
constexpr double kHeatRound = kSumRound / kHeatFade;

double least_of(std::initializer_list<double> numbers) {
  return std::min(numbers);
}

std::int64_t longer_time_ns(double time_s, double periods, std::int64_t period_ns) {
  const auto of_periods = static_cast<std::int64_t>(periods * static_cast<double>(period_ns));
  return std::max(nanoseconds(time_s), of_periods);
}

double stored_J(double force_N, double stiffness_N_per_m) {
  return stiffness_N_per_m > 0.0 ? 0.5 * force_N * force_N / stiffness_N_per_m : 0.0;
}

}  // namespace

JudgedMotors::JudgedMotors(std::span<const MotorDescription> motors) : count_(motors.size()) {
  for (std::size_t i = 0; i < count_; ++i) {
    const int n = static_cast<int>(i);
    directions_.col(n) = Vec3(motors[i].direction_device.data()).normalized();
    peak_N_[n] = motors[i].peak_force_N;
    continuous_N_[n] = motors[i].continuous_force_N;
  }
  Mat3 gram = directions_.transpose() * directions_;
  for (int n = static_cast<int>(count_); n < 3; ++n) gram(n, n) = 1.0;
  inverse_ = gram.inverse() * directions_.transpose();
}

Vec3 JudgedMotors::part(const Vec3& force_N) const {
  return directions_ * efforts_N(force_N);
}

Vec3 JudgedMotors::efforts_N(const Vec3& force_N) const {
  return inverse_ * force_N;
}

Vec3 JudgedMotors::loads(const Vec3& force_N) const {
  Vec3 loads = efforts_N(force_N);
  for (int n = 0; n < 3; ++n) loads[n] = continuous_N_[n] > 0.0 ? loads[n] / continuous_N_[n] : 0.0;
  return loads;
}

Vec3 JudgedMotors::largest_loads(double force_N) const {
  Vec3 loads = Vec3::Zero();
  for (int n = 0; n < 3; ++n) {
    double effort_N = force_N * inverse_.row(n).norm();
    if (peak_N_[n] > 0.0) effort_N = std::min(effort_N, peak_N_[n]);
    if (continuous_N_[n] > 0.0) loads[n] = effort_N / continuous_N_[n];
  }
  return loads;
}

double JudgedMotors::overload(const Vec3& force_N) const {
  const Vec3 efforts = efforts_N(force_N);
  double overload = 0.0;
  for (int n = 0; n < 3; ++n) {
    if (peak_N_[n] > 0.0) overload = std::max(overload, std::abs(efforts[n]) / peak_N_[n]);
  }
  return overload;
}

void GovernorJudge::Rules::add_factor(GovernorRule rule, double factor) {
  if (factor < 1.0 - kJudgeRound) must |= rule;
  if (factor < 1.0 + kJudgeRound) may |= rule;
}

GovernorJudge::GovernorJudge(const DeviceDescription& device, double clamp_N, bool watches_energy)
    : device_(device),
      clamp_N_(clamp_N),
      moves_(device.moves_motors),
      watches_(device.moves_motors && watches_energy),
      mechanics_(assumed_mechanics(device)) {
  if (moves_) state_ = GovernorState::kWaits;
  if (watches_) half_step_m_ = 0.5 * device.encoder_quantum_m;
}

void GovernorJudge::begin_start() {
  state_ = GovernorState::kWaits;
  least_calm_ns_ = most_calm_ns_ = 0;
}

// A pause: nothing that was before counts, but a trip, the ramps and the heat.
void GovernorJudge::pause() {
  if (last_now_ns_ != 0) paused_at_ns_ = last_now_ns_;
  last_now_ns_ = 0;
  ++path_ends_;
  last_N_.setZero();
  has_last_ = false;
  places_.clear();
  row_.clear();
  watched_N_.clear();
  commanded_.clear();
  acted_N_.setZero();
  acted_late_N_.setZero();
  way_ticks_ = 0;
  was_released_ = false;
  tripped_N_ = 0.0;
  if (moves_ && state_ != GovernorState::kTripped) begin_start();
}

void GovernorJudge::judge(const JudgedTick& tick) {
  ++counts_.ticks;
  const std::uint32_t rules = tick.record.rules;
  for (int rule = 0; rule < kGovernorRuleCount; ++rule) counts_.rules[rule] += rules >> rule & 1u;
  if (tick.restarts && moves_ && state_ != GovernorState::kTripped) begin_start();
  find_times(tick);
  const JudgedMotors motors(tick.motors);
  Vec3 wanted_N = vec3(tick.wanted.force_device_N);
  const bool has_bad_force = !wanted_N.allFinite() ||
                             (tick.wanted.faults & kFaultNonFiniteForce) != 0 ||
                             (watches_ && !vec3(tick.wanted.full_force_device_N).allFinite());
  if (has_bad_force) wanted_N.setZero();
  wanted_N_ = wanted_N.norm();
  const bool has_limits = moves_ || device_.motor_count > 0;
  const Vec3 pushed_N = has_limits ? motors.part(wanted_N) : wanted_N;
  find_way(tick);
  if (tick.rearms && state_ == GovernorState::kTripped) begin_start();
  const bool was_tripped = state_ == GovernorState::kTripped;
  find_trip(tick, has_bad_force);
  ASSERT_NO_FATAL_FAILURE(find_state(tick, pushed_N));
  if (reason_ != TripReason::kNone && !was_tripped) {
    ++counts_.trips[static_cast<std::size_t>(reason_)];
    tripped_N_ = last_N_.norm();
    tripped_ns_ = pushes_ = 0;
  }

  // The rules of which the force of the tick is not needed.
  Rules must;
  const double missing = (wanted_N - pushed_N).norm() / std::max(wanted_N.norm(), 1e-300);
  if (missing > kJudgeRound) must.must |= kRuleMotors;
  if (missing > 0.0 && motors.count() < 3 && has_limits) must.may |= kRuleMotors;
  const double length_N = pushed_N.norm();
  const double clamp = length_N > 0.0 ? clamp_N_ / length_N : 2.0;
  must.add_factor(kRuleClamp, clamp);
  const double overload = has_limits ? motors.overload(pushed_N) : 0.0;
  const double peak = overload > 0.0 ? 1.0 / overload : 2.0;
  must.add_factor(kRulePeak, peak);
  double factor = least_of({1.0, clamp, peak});
  if (moves_) {
    must.add(kRuleBadSample, is_bad_);
    must.add(kRuleStale, is_stale_);
    must.add(kRuleOrder, is_out_of_order_);
    must.add(kRuleLate, is_late_);
    const bool drives = last_N_.norm() > Limits::kMovingShare * clamp_N_;
    const bool is_fast = has_speed_ && least_speed_ > Limits::kTopSpeed_m_per_s;
    const bool may_be_fast = has_speed_ && most_speed_ > Limits::kTopSpeed_m_per_s;
    if (is_fast && drives) must.must |= kRuleSpeed;
    if (may_be_fast && drives) must.may |= kRuleSpeed;
    const double workspace = workspace_factor(tick.record);
    must.add_factor(kRuleWorkspace, workspace);
    const bool was_ever = has_been_interrupted_;
    const double ease = was_ever ? seconds(since_interruption_ns_) / Limits::kEase_s : 1.0;
    must.add(kRuleEase, ease < 1.0);
    double start = 1.0;
    if (state_ == GovernorState::kStarts) start = seconds(start_ns_) / Limits::kStart_s;
    if (state_ == GovernorState::kWaits || state_ == GovernorState::kTripped) start = 0.0;
    must.add(state_ == GovernorState::kTripped ? kRuleTripped : kRuleStart, start < 1.0);
    // This trip comes after the rule start.
    if (reason_ == TripReason::kUnstable) must.may |= kRuleStart;
    factor = least_of({factor, workspace, ease, start});
    ramp_share_ = least_of({1.0, ease, start});
  }
  ASSERT_NO_FATAL_FAILURE(judge_limits(tick, motors));
  ASSERT_NO_FATAL_FAILURE(judge_force(tick, motors, pushed_N, factor, must));
  ASSERT_EQ(must.must & ~rules, 0u) << "a rule that acted has no bit";
  ASSERT_EQ(rules & ~must.may, 0u) << "a rule has a bit that did not act";
  ASSERT_NO_FATAL_FAILURE(judge_release(tick));
  ASSERT_NO_FATAL_FAILURE(judge_energy(tick));

  const Vec3 force_N = vec3(tick.record.force_device_N);
  last_N_ = force_N;
  if (watches_) {
    commanded_.push_front(force_N);
    if (commanded_.size() > DelayTicks::kMostWhole + 2) commanded_.pop_back();
    const double share =
        -std::expm1(-seconds(step_ns_) / seconds(MotorHeatLimits::kTimeConstant_ns));
    const Vec3 loads = motors.loads(force_N);
    mean_square_ += share * (Vec3(loads.cwiseProduct(loads)) - mean_square_);
    // One step cannot carry a mean square beyond 1 while the step is short for the load.
    const Vec3 most = motors.largest_loads(clamp_N_);
    const double most2 = most.cwiseProduct(most).maxCoeff();
    if (share * (most2 - 1.0) > kHeatFade * (1.0 - share)) has_long_steps_ = true;
    if (!has_long_steps_) {
      ASSERT_LE(mean_square_.maxCoeff(), 1.0 + kSumRound) << "too warm";
    }
  }
  was_interrupted_ = is_interrupted_;
}

void GovernorJudge::find_times(const JudgedTick& tick) {
  period_s_ = tick.time.dt_s;
  period_ns_ = nanoseconds(period_s_);
  const bool is_measured = tick.time.now_ns != 0 && last_now_ns_ != 0;
  step_ns_ = is_measured ? tick.time.now_ns - last_now_ns_ : period_ns_;
  last_now_ns_ = tick.time.now_ns;
  now_ns_ += step_ns_;
  if (paused_at_ns_ != 0 && watches_) {  // motors cool in a pause
    const std::int64_t pause_ns = tick.time.now_ns - paused_at_ns_ - step_ns_;
    mean_square_ *= std::exp(-static_cast<double>(pause_ns) /
                             static_cast<double>(MotorHeatLimits::kTimeConstant_ns));
  }
  paused_at_ns_ = 0;
  late_ns_ = std::max(tick.time.late_ns, step_ns_ - period_ns_);

  is_out_of_order_ = moves_ && has_sample_ && tick.sample.sequence < sequence_;
  is_new_ = !has_sample_ || tick.sample.sequence > sequence_;
  has_sample_ = true;
  if (!is_out_of_order_) sequence_ = tick.sample.sequence;
  age_ns_ = is_new_ && tick.sample.is_valid ? 0 : age_ns_ + step_ns_;

  is_bad_ = (tick.wanted.faults & kFaultsWithoutForce) != 0;
  is_stale_ = age_ns_ > longer_time_ns(Limits::kStale_s, Limits::kStalePeriods, period_ns_);
  is_late_ = late_ns_ > longer_time_ns(Limits::kLate_s, Limits::kLatePeriods, period_ns_);
  is_interrupted_ = moves_ && (is_bad_ || is_stale_ || is_late_);
  const std::int64_t ramp_ns = std::min(step_ns_, 2 * period_ns_);
  since_interruption_ns_ = is_interrupted_ ? 0 : since_interruption_ns_ + ramp_ns;
  has_been_interrupted_ = has_been_interrupted_ || is_interrupted_;
  if (is_new_ && !is_bad_) {
    places_.push_back({now_ns_ - age_ns_, vec3(tick.record.device_m)});
    find_speeds();
  }
}

// The speed over a window: the newest position that is a window older. The window rounds by 1/64,
// and a position that follows the one before within 1/32 of the window need not be kept.
void GovernorJudge::find_speeds() {
  has_speed_ = false;
  const double window_s =
      seconds(longer_time_ns(Limits::kSpeedWindow_s, Limits::kSpeedWindowPeriods, period_ns_));
  const Place& newest = places_.back();
  double first_age_s = 0.0;
  for (std::size_t n = places_.size() - 1; n-- > 0;) {
    const double age_s = seconds(newest.time_ns - places_[n].time_ns);
    if (age_s < window_s * (1.0 - 1.0 / 64)) continue;
    if (!has_speed_) first_age_s = age_s;
    if (age_s > first_age_s + window_s / 32 + 1e-9) {
      places_.erase(places_.begin(), places_.begin() + static_cast<std::ptrdiff_t>(n));
      break;
    }
    const double speed = (newest.p_m - places_[n].p_m).norm() / age_s;
    least_speed_ = has_speed_ ? std::min(least_speed_, speed) : speed;
    most_speed_ = has_speed_ ? std::max(most_speed_, speed) : speed;
    has_speed_ = true;
  }
}

// Whether the tick must trip, and why.
void GovernorJudge::find_trip(const JudgedTick& tick, bool has_bad_force) {
  reason_ = TripReason::kNone;
  may_trip_by_speed_ = false;
  if (!moves_) return;
  if (is_late_ && state_ != GovernorState::kTripped) {
    const std::int64_t very_late_ns =
        longer_time_ns(Limits::kLateRestart_s, Limits::kLatePeriods, period_ns_);
    if (late_ns_ > very_late_ns) begin_start();
  }
  const auto trip = [&](TripReason reason, bool trips) {
    if (trips && reason_ == TripReason::kNone) reason_ = reason;
  };
  if (is_bad_) {
    bad_ns_.push_back(now_ns_);
    if (bad_ns_.size() > 3) bad_ns_.pop_front();
    trip(TripReason::kBadSamples,
         bad_ns_.size() == 3 && now_ns_ - bad_ns_.front() <= nanoseconds(Limits::kBadSamples_s));
  }
  const std::int64_t most_ns =
      std::max(nanoseconds(Limits::kStaleTrip_s),
               longer_time_ns(Limits::kStale_s, Limits::kStalePeriods, period_ns_));
  trip(TripReason::kStale, age_ns_ > most_ns);
  const bool drives = last_N_.norm() > Limits::kMovingShare * clamp_N_;
  if (has_speed_ && drives) {
    trip(TripReason::kSpeed, least_speed_ > Limits::kTopSpeed_m_per_s);
    may_trip_by_speed_ = most_speed_ > Limits::kTopSpeed_m_per_s;
  }
  trip(TripReason::kBadForce, has_bad_force);
  trip(TripReason::kDevice, tick.sample.asks_for_trip);
}

void GovernorJudge::find_state(const JudgedTick& tick, const Vec3& pushed_N) {
  const GovernorStatus& status = tick.status;
  if (!moves_) {
    ASSERT_EQ(status.state, GovernorState::kRuns);
    ASSERT_EQ(status.trips, 0u);
    return;
  }
  if (state_ == GovernorState::kTripped) {
    ASSERT_EQ(status.state, GovernorState::kTripped) << "a trip lasts until it is rearmed";
    ASSERT_EQ(status.trips, trips_) << "a trip that lasts counts once";
    return;
  }
  if (status.trips != trips_) {
    ASSERT_EQ(status.trips, trips_ + 1);
    ASSERT_EQ(status.state, GovernorState::kTripped);
    const TripReason reason = status.trip.reason;
    const bool may_be = reason == TripReason::kSpeed && may_trip_by_speed_;
    const bool is_unstable = reason == TripReason::kUnstable && reason_ == TripReason::kNone;
    if (is_unstable) {
      ASSERT_TRUE(watches_);
      ASSERT_FALSE(pushed_N.isZero(0.0)) << "without a force, nothing is unstable";
      ASSERT_FALSE(is_interrupted_);
      ASSERT_NE(tick.record.rules & kRuleSoft, 0u) << "the contact was not softened before";
      ASSERT_GT(status.trip.value, PassivityLimits::kSoften_J);
    } else if (!may_be) {
      ASSERT_EQ(kTripReasonNames[static_cast<std::size_t>(reason)],
                kTripReasonNames[static_cast<std::size_t>(reason_)]);
    }
    reason_ = reason;
    trips_ = status.trips;
    state_ = GovernorState::kTripped;
    return;
  }
  ASSERT_EQ(reason_, TripReason::kNone) << "no trip";
  const std::int64_t ramp_ns = std::min(step_ns_, 2 * period_ns_);
  if (state_ == GovernorState::kWaits) {
    const bool is_light = tick.record.contact == 0 || pushed_N.norm() < Limits::kStartForce_N;
    const bool may_be_calm =
        !is_interrupted_ && is_light && has_speed_ && least_speed_ < Limits::kStartSpeed_m_per_s;
    const bool is_calm = may_be_calm && most_speed_ < Limits::kStartSpeed_m_per_s;
    least_calm_ns_ = is_calm ? least_calm_ns_ + ramp_ns : 0;
    most_calm_ns_ = may_be_calm ? most_calm_ns_ + ramp_ns : 0;
    const bool starts = status.state == GovernorState::kStarts;
    ASSERT_TRUE(starts || status.state == GovernorState::kWaits);
    ASSERT_TRUE(starts || least_calm_ns_ < nanoseconds(Limits::kCalm_s)) << "does not start";
    ASSERT_TRUE(!starts || most_calm_ns_ >= nanoseconds(Limits::kCalm_s)) << "starts too early";
    start_ns_ = 0;
  } else if (state_ == GovernorState::kStarts) {
    start_ns_ += ramp_ns;
    const bool runs = start_ns_ >= nanoseconds(Limits::kStart_s);
    ASSERT_EQ(status.state, runs ? GovernorState::kRuns : GovernorState::kStarts);
  } else {
    ASSERT_EQ(status.state, GovernorState::kRuns);
  }
  state_ = status.state;
}

double GovernorJudge::workspace_factor(const TickRecord& record) const {
  double factor = 2.0;
  for (int k = 0; k < device_.sensed_axes; ++k) {
    const double low_m = device_.workspace_low_m[static_cast<std::size_t>(k)];
    const double high_m = device_.workspace_high_m[static_cast<std::size_t>(k)];
    if (!(high_m > low_m)) continue;
    const double beyond_m = std::max(low_m - record.device_m[k], record.device_m[k] - high_m);
    const double fade_m = 0.5 * Limits::kFadeShare * (high_m - low_m);
    if (beyond_m > 0.0) factor = std::min(factor, 1.0 - std::min(1.0, beyond_m / fade_m));
  }
  return factor;
}

// What no force of any tick may exceed.
void GovernorJudge::judge_limits(const JudgedTick& tick, const JudgedMotors& motors) {
  const Vec3 force_N = vec3(tick.record.force_device_N);
  ASSERT_TRUE(force_N.allFinite());
  const double length_N = force_N.norm();
  ASSERT_LE(length_N, clamp_N_);
  if (!moves_ && device_.motor_count == 0) return;
  // A sum of two parts may be much smaller than they are.
  const double largest_N = std::max(length_N, wanted_N_);
  ASSERT_LE((force_N - motors.part(force_N)).norm(), kJudgeRound * largest_N)
      << "not in the span: rules " << std::hex << tick.record.rules;
  ASSERT_LE(motors.overload(force_N), 1.0 + kJudgeRound);
  if (!moves_) return;
  if (length_N > 0.0) {
    const double before_N = std::max(0.0, last_N_.dot(force_N) / length_N);
    const double step_s = std::min(seconds(step_ns_), 2.0 * period_s_);
    ASSERT_LE(length_N, (before_N + Limits::kSlew_N_per_s * step_s) * (1.0 + kJudgeRound))
        << "grows too fast: rules " << std::hex << tick.record.rules;
  }
  // Every other rule that takes the whole force away.
  if (is_interrupted_ || state_ == GovernorState::kWaits) {
    ASSERT_EQ(length_N, 0.0);
  }
  if (state_ == GovernorState::kTripped && (tick.record.rules & kRuleRelease) == 0) {
    ASSERT_EQ(length_N, 0.0);
  }
}

// The factor of heat by its definition.
double GovernorJudge::heat_factor(const Vec3& loads) const {
  double factor = 2.0;
  for (int n = 0; n < 3; ++n) {
    const double w = std::abs(loads[n]);
    if (!(w > 1.0)) continue;
    const double x = std::clamp((1.0 - mean_square_[n]) / kHeatFade, 0.0, 1.0);
    factor = std::min(factor, std::sqrt(1.0 + (w * w - 1.0) * x) / w);
  }
  return factor;
}

// The force, as far as the judge can predict it. factor: what all rules but those of energy leave.
void GovernorJudge::judge_force(const JudgedTick& tick, const JudgedMotors& motors,
                                const Vec3& pushed_N, double factor, Rules& rules) {
  const Vec3 force_N = vec3(tick.record.force_device_N);
  const std::uint32_t bits = tick.record.rules;
  constexpr std::uint32_t kEnergyRules =
      kRuleDamping | kRuleSoft | kRuleRestart | kRuleHeat | kRuleRelease;
  if (!moves_) {
    ASSERT_LE((force_N - factor * pushed_N).norm(), kJudgeRound * wanted_N_);
    ++counts_.exact;
    return;
  }
  if (!watches_) {
    ASSERT_EQ(bits & kEnergyRules, 0u);
  } else {
    rules.may |= bits & (kRuleDamping | kRuleSoft | kRuleRestart | kRuleRelease);
  }
  if (bits & kRuleRelease) {
    rules.may |= bits & (kRuleHeat | kRuleSlew);
    ASSERT_NO_FATAL_FAILURE(judge_heat(tick, motors, motors.largest_loads(clamp_N_)));
    judge_damping(tick, motors, pushed_N, -1.0);
    judge_spring(tick, 0.0, 1.0);
    return;
  }
  const bool is_known = (bits & (kRuleSoft | kRuleRestart)) == 0;
  const Vec3 before_heat_N = factor * pushed_N;
  // Heat: a load that another rule has lowered wants no more.
  double heat = watches_ ? heat_factor(motors.loads(before_heat_N)) : 2.0;
  if (watches_ && is_known) {
    if (heat < 1.0 - kHeatRound) rules.must |= kRuleHeat;
    if (heat < 1.0 + kHeatRound) rules.may |= kRuleHeat;
  } else if (watches_) {
    rules.may |= heat < 1.0 + kHeatRound ? kRuleHeat : 0u;
  }
  heat = std::min(heat, 1.0);
  const double even = heat * factor;
  const Vec3 even_N = even * pushed_N;
  // A part may be much smaller than the wanted force, with whose rounding it comes.
  const double round = heat < 1.0 ? kHeatRound : 0.0;
  const double tolerance_N = kJudgeRound * wanted_N_ + round * pushed_N.norm();
  if ((bits & kRuleDamping) == 0) {
    ASSERT_NO_FATAL_FAILURE(judge_heat(tick, motors, motors.loads(before_heat_N)));
  }
  if ((bits & kRuleDamping) != 0) {
    rules.may |= kRuleSlew | kRuleHeat;
    ASSERT_NO_FATAL_FAILURE(judge_heat(tick, motors, motors.largest_loads(clamp_N_)));
    ASSERT_FALSE(is_interrupted_);
    ASSERT_NE(state_, GovernorState::kWaits);
    judge_damping(tick, motors, even_N, is_known ? even : -1.0);
    judge_spring(tick, 0.0, 1.0);
    return;
  }
  // Without damping, the force is a share of the wanted one.
  const double pushed2 = pushed_N.squaredNorm();
  const double share = pushed2 > 0.0 ? force_N.dot(pushed_N) / pushed2 : 0.0;
  ASSERT_LE((force_N - share * pushed_N).norm(), tolerance_N);
  ASSERT_GE(share, 0.0);
  ASSERT_LE(share * std::sqrt(pushed2), even * std::sqrt(pushed2) + tolerance_N);
  double slew = 2.0;
  const double length_N = even_N.norm();
  if (length_N > 0.0) {
    const double before_N = std::max(0.0, last_N_.dot(even_N) / length_N);
    slew = (before_N + Limits::kSlew_N_per_s * std::min(seconds(step_ns_), 2.0 * period_s_)) /
           length_N;
  }
  if (is_known) {
    rules.add_factor(kRuleSlew, slew);
    ASSERT_LE((force_N - std::min(1.0, slew) * even_N).norm(), tolerance_N);
    ++counts_.exact;
  } else {
    rules.may |= kRuleSlew;
  }
  judge_damping(tick, motors, even_N,
                is_known || (bits & kRuleSlew) == 0 ? (is_known ? even : share) : -1.0);
  // The spring: its share is that of the force, if no other rule left less.
  double least = share, most = 1.0;
  const bool is_binding =
      (bits & kRuleSlew) == 0 && share < factor * (1.0 - kHeatRound) && (bits & kRuleHeat) == 0;
  if (is_known) least = 1.0;
  if (!is_known && is_binding) most = share;
  judge_spring(tick, least, most);
}

// No motor gets more than its heat allows it.
void GovernorJudge::judge_heat(const JudgedTick& tick, const JudgedMotors& motors,
                               const Vec3& wanted) {
  if (!watches_) return;
  const Vec3 loads = motors.loads(vec3(tick.record.force_device_N));
  for (int n = 0; n < 3; ++n) {
    const double x = std::clamp((1.0 - mean_square_[n]) / kHeatFade, 0.0, 1.0);
    const double most2 = std::max(1.0, 1.0 + (wanted[n] * wanted[n] - 1.0) * x);
    ASSERT_LE(loads[n] * loads[n], most2 * (1.0 + kHeatRound)) << n;
  }
}

// factor: what the rules have left of the wanted force; < 0: unknown.
void GovernorJudge::judge_damping(const JudgedTick& tick, const JudgedMotors& motors,
                                  const Vec3& even_N, double factor) {
  if (!watches_) return;
  const Vec3 force_N = vec3(tick.record.force_device_N);
  const std::uint32_t bits = tick.record.rules;
  const bool is_damped = (bits & kRuleDamping) != 0;
  // Samples in a row.
  if (is_bad_ || is_interrupted_ || state_ == GovernorState::kTripped) {
    row_.clear();
  } else if (is_new_) {
    if (!way_.is_known || way_.time_s == 0.0) row_.clear();
    row_.push_back({now_ns_, vec3(tick.record.device_m), tick.record.tick});
  }
  const auto window = static_cast<std::size_t>(controller_velocity_ticks(period_s_));
  while (row_.size() > window + 1) row_.pop_front();

  // At a limit, what it has taken away is unknown.
  const bool is_limited = (bits & kRuleHeat) != 0 || force_N.norm() > (1.0 - 1e-9) * clamp_N_ ||
                          motors.overload(force_N) > 1.0 - 1e-9;
  Vec3 vibration_N = Vec3::Zero();
  if (tick.sources.has_effects) vibration_N = motors.part(tick.sources.effects_N[0]);
  std::optional<Vec3> watched_N;
  if (factor >= 0.0) {
    const double length_N = even_N.norm();
    const bool is_whole = !is_damped || ((bits & kRuleSlew) == 0 && !is_limited);
    double left = 1.0;
    if (!is_damped && length_N > 0.0) left = std::min(1.0, force_N.norm() / length_N);
    if (is_whole) watched_N = left * (even_N - factor * vibration_N);
  }
  if (state_ == GovernorState::kTripped) watched_N = Vec3(Vec3::Zero());

  if (is_damped && factor >= 0.0 && (bits & kRuleSlew) == 0 && !is_limited) {
    const Vec3 damping_N = force_N - even_N;
    const double round_N = (kSumRound + kJudgeRound) * (force_N.norm() + even_N.norm() + wanted_N_);
    ASSERT_GE(force_N.dot(even_N), -round_N * even_N.norm()) << "pulls into the surface";
    if (is_new_) {
      ASSERT_GE(row_.size(), 2u) << "damps without a velocity";
      // As many samples as fit into the window, at least one.
      std::size_t samples = window;
      double late_s = 0.0;
      if (hold_ns_ > period_ns_) {
        const double window_s = static_cast<double>(window) * period_s_;
        const double hold_s = seconds(hold_ns_);
        samples = static_cast<std::size_t>(std::max(1.0, std::round(window_s / hold_s)));
        late_s = hold_s - period_s_ +
                 0.5 * std::max(0.0, static_cast<double>(samples) * hold_s - window_s);
      }
      samples = std::min(samples, row_.size() - 1);
      const Place& then = row_[row_.size() - 1 - samples];
      const Place& now = row_.back();
      const double time_s = seconds(now.time_ns - then.time_ns);
      const Vec3 velocity = (now.p_m - then.p_m) / time_s;
      const double most =
          largest_damping_Ns_per_m(mechanics_.mass_kg, mechanics_.delay.most_s + late_s, period_s_,
                                   static_cast<int>(window));
      // Both places are within half a step of their samples.
      const double steps = 2.0 * half_step_m_ * std::sqrt(3.0) / time_s;
      ASSERT_LE(damping_N.norm(), most * (velocity.norm() + steps) * (1.0 + kJudgeRound) + round_N);
      // With a sample in every tick.
      const std::size_t ticks = now.tick - then.tick == samples ? samples : 0;
      if (watched_N && ticks > 0 && watched_N_.size() >= ticks && watched_N_[ticks - 1]) {
        const Vec3 changed_N = *watched_N - *watched_N_[ticks - 1];
        const double change_N = changed_N.norm();
        const double change_round_N = round_N + kSumRound * watched_N_[ticks - 1]->norm();
        if (half_step_m_ == 0.0 && change_N > 1e3 * change_round_N) {
          const Vec3 along = motors.part(changed_N).normalized();
          const Vec3 across_N = damping_N - damping_N.dot(along) * along;
          ASSERT_LE(across_N.norm(), damping_N.norm() * 4.0 * change_round_N / change_N + round_N)
              << "damps across the change of the force";
          // Motors that have turned meanwhile cannot push along the change.
          if ((changed_N - motors.part(changed_N)).norm() < change_round_N) {
            ASSERT_LE(damping_N.dot(velocity), 2.0 * round_N * velocity.norm())
                << "pushes along the motion";
          }
          ++counts_.damped;
        }
      }
    } else {
      ASSERT_TRUE(had_damping_);
    }
  }
  if (is_new_ || is_interrupted_) had_damping_ = is_damped;
  watched_N_.push_front(watched_N);
  if (watched_N_.size() > static_cast<std::size_t>(kMostControllerTicks)) watched_N_.pop_back();
}

// The force of the spring is between these shares of K e. It stores f^2 / 2K. Beyond what the way
// of the hand explains, this energy comes from the tank, from nodes that move, and, for a time,
// from what an interruption had taken away.
void GovernorJudge::judge_spring(const JudgedTick& tick, double least, double most) {
  if (!watches_) return;
  const double stiffness = tick.sources.stiffness_N_per_m;
  const double spring_N = stiffness * tick.sources.lag_m;
  const std::int64_t ramp_ns = std::min(step_ns_, 2 * period_ns_);
  const double ramp_s = seconds(ramp_ns);
  if (!(spring_N > 0.0)) {
    last_spring_N_ = last_stiffness_ = least_N_ = most_N_ = returns_J_ = 0.0;
    tank_J_ = std::min(SpringRestart::kTank_J,
                       tank_J_ + SpringRestart::kTank_J / SpringRestart::kRefill_s * ramp_s);
    return;
  }
  if (tick.sources.nodes_moved) {
    tank_J_ = std::min(SpringRestart::kTank_J, tank_J_ + SpringRestart::kNodePower_W * ramp_s);
  }
  if (is_interrupted_) {
    if (!was_interrupted_) returns_J_ += stored_J(most_N_, last_stiffness_);
    returns_ns_ = 0;
    least_N_ = most_N_ = 0.0;
    last_spring_N_ = spring_N;
    last_stiffness_ = stiffness;
    return;
  }
  // What a ramp holds back stays withheld.
  if (returns_J_ == 0.0) most = std::min(most, ramp_share_ * (1.0 + kJudgeRound));
  returns_ns_ += ramp_ns;
  // A stiffness that falls takes its share of the force, one that grows leaves the force.
  double before_N = most_N_;
  if (last_stiffness_ > 0.0) before_N *= std::min(1.0, stiffness / last_stiffness_);
  double explained_N = was_interrupted_ ? 0.0 : stiffness * way_.way_m.norm();
  if (way_.is_gap && way_.is_known && !was_interrupted_) {
    const double work_J = std::max(0.0, -way_.work_J) + way_.uncertain_J;
    const double by_work_N = std::sqrt(before_N * before_N + 2.0 * stiffness * work_J) - before_N;
    explained_N = std::min(explained_N, by_work_N);
  }
  const double free_N = before_N + explained_N + SpringRestart::kRounding * spring_N;
  const double free_J = stored_J(free_N, stiffness);
  const double now_J = stored_J(least * spring_N, stiffness);
  const double spent_J = std::max(0.0, now_J - free_J);
  const double round_J = kSumRound * (now_J + free_J) + kJudgeRound * SpringRestart::kTank_J;
  ASSERT_LE(spent_J, tank_J_ + returns_J_ + round_J) << "the spring gives what nobody has put in";
  const double from_returns_J = std::min(returns_J_, spent_J);
  const double total_J = tank_J_ + returns_J_;
  returns_J_ -= from_returns_J;
  tank_J_ = std::max(0.0, tank_J_ - (spent_J - from_returns_J));
  most_N_ = std::min(most * spring_N, std::sqrt(2.0 * stiffness * (free_J + total_J)));
  least_N_ = least * spring_N;
  if (seconds(returns_ns_) >= SpringRestart::kReturn_s) returns_J_ = 0.0;
  last_spring_N_ = spring_N;
  last_stiffness_ = stiffness;
  ++counts_.spring;
}

// After a trip, the force only resists, for 30 ms.
void GovernorJudge::judge_release(const JudgedTick& tick) {
  const Vec3 force_N = vec3(tick.record.force_device_N);
  if (state_ != GovernorState::kTripped) {
    ASSERT_EQ(tick.record.rules & kRuleRelease, 0u);
    was_released_ = false;
    return;
  }
  const bool has_just_tripped =
      reason_ != TripReason::kNone && tick.status.trip.tick == tick.record.tick;
  if (!has_just_tripped) {
    tripped_ns_ += step_ns_;
    if (was_released_ && last_N_.dot(way_.way_m) > 0.0) ++pushes_;
  }
  was_released_ = (tick.record.rules & kRuleRelease) != 0;
  if (!was_released_) return;
  ++counts_.released;
  const TripReason reason = tick.status.trip.reason;
  ASSERT_TRUE(reason == TripReason::kSpeed || reason == TripReason::kUnstable);
  ASSERT_FALSE(is_interrupted_);
  ASSERT_FALSE(tick.sample.asks_for_trip);
  ASSERT_LT(pushes_, GentleReleaseLimits::kMostTurns) << "swings with the hand";
  const double left =
      1.0 - static_cast<double>(tripped_ns_) / static_cast<double>(GentleReleaseLimits::kFall_ns);
  ASSERT_GT(left, 0.0);
  ASSERT_LE(force_N.norm(), left * tripped_N_ * (1.0 + kJudgeRound));
}

// The force that acts, on the average of a tick, a delay after its sample.
Vec3 GovernorJudge::acting_N(double delay_s) const {
  const double ticks = delay_s / period_s_;
  // Whole ticks stay whole: the quotient of up to 120 rounds by less than kWhole.
  constexpr double kWhole = 1e-12;
  const double whole = std::floor(ticks + kWhole);
  const double share = std::max(0.0, ticks - whole);
  const auto at = [&](double n) {
    const auto index = static_cast<std::size_t>(n);
    return index < commanded_.size() ? commanded_[index] : Vec3(Vec3::Zero());
  };
  if (share < kWhole) return at(whole);
  return share * at(whole + 1.0) + (1.0 - share) * at(whole);
}

void GovernorJudge::find_way(const JudgedTick& tick) {
  way_ = {};
  if (!watches_) {
    if (is_bad_) has_last_ = false;
    if (is_bad_) return;
    way_.is_known = has_last_;
    if (has_last_) way_.way_m = vec3(tick.record.device_m) - last_m_;
    way_.work_J = way_.late_J = last_N_.dot(way_.way_m);
    way_.size_J = last_N_.norm() * way_.way_m.norm();
    has_last_ = true;
    last_m_ = vec3(tick.record.device_m);
    return;
  }
  acted_N_ += acting_N(mechanics_.delay.least_s);
  acted_late_N_ += acting_N(mechanics_.delay.most_s);
  way_ns_ += step_ns_;
  ++way_ticks_;
  if (is_bad_ || !is_new_) return;
  if (has_last_) {
    way_.way_m = vec3(tick.record.device_m) - last_m_;
    way_.time_s = seconds(way_ns_);
    if (way_ns_ >= hold_ns_ || now_ns_ - hold_since_ns_ > 1'000'000'000) {
      hold_ns_ = way_ns_;
      hold_since_ns_ = now_ns_;
    }
    way_.is_known = way_.way_m.norm() <=
                    2.0 * Limits::kTopSpeed_m_per_s * std::max(way_.time_s, seconds(period_ns_));
    if (!way_.is_known) way_.way_m.setZero();
    path_ends_ += way_.is_known ? 0 : 1;
    const double periods = std::max(period_s_, device_.rate_Hz > 0.0 ? 1.0 / device_.rate_Hz : 0.0);
    way_.is_gap = way_.time_s > 2.5 * periods;
    way_.work_J = acted_N_.dot(way_.way_m) / way_ticks_;
    way_.late_J = acted_late_N_.dot(way_.way_m) / way_ticks_;
    way_.uncertain_J = 2.0 * half_step_m_ * acted_N_.lpNorm<1>() / way_ticks_;
    way_.size_J = (acted_N_.norm() + acted_late_N_.norm()) * way_.way_m.norm() / way_ticks_;
  }
  has_last_ = true;
  last_m_ = vec3(tick.record.device_m);
  way_ns_ = 0;
  way_ticks_ = 0;
  acted_N_.setZero();
  acted_late_N_.setZero();
}

void GovernorJudge::judge_energy(const JudgedTick& tick) {
  given_J_ += way_.work_J;
  given_late_J_ += way_.late_J;
  worked_J_ += way_.size_J;
  // Between the steps of the encoders, a place is within half a step of its sample. That moves the
  // work by half a step for each change of the force, and for each end of a path.
  const Vec3 force_N = vec3(tick.record.force_device_N);
  encoder_J_ += half_step_m_ * (force_N - last_N_).lpNorm<1>();
  largest_N_ = std::max(largest_N_, force_N.lpNorm<1>());
  const double round_J =
      1e-9 * worked_J_ + encoder_J_ + 2.0 * half_step_m_ * largest_N_ * (1.0 + path_ends_);
  ASSERT_LE(std::abs(tick.status.given_J - given_J_), round_J);
  ASSERT_LE(std::abs(tick.status.given_late_J - given_late_J_), round_J);
  ASSERT_LE(std::abs(tick.status.encoder_J - encoder_J_), kSumRound * encoder_J_);
  ASSERT_TRUE(std::isfinite(tick.status.account_J));
}

}  // namespace palpate::test
