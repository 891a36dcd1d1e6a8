#include "haptics/safety_governor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/haptic_loop.h"  // is_time_step
#include "haptics/nanoseconds.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

using Limits = GovernorLimits;

// The longer one of a time and a number of periods.
std::int64_t longer_ns(double time_s, double periods, std::int64_t period_ns) {
  return std::max<std::int64_t>(nanoseconds(time_s),
                                std::llround(periods * static_cast<double>(period_ns)));
}

std::span<const MotorDescription> motors_of(const DeviceDescription& device) {
  return std::span(device.motors)
      .first(static_cast<std::size_t>(
          std::clamp(device.motor_count, 0, static_cast<int>(device.motors.size()))));
}

// True if a vector is so clearly shorter than a limit that rounding cannot matter. It saves a root
// in the ticks in which no rule acts.
bool is_far_below(const Vec3& v, double limit) {
  return v.squaredNorm() < 0.25 * limit * limit;
}

// The factor that shortens a force of this length to a limit, at most 1.
double factor_to(double limit_N, double length_N) {
  return length_N > limit_N ? kBelowLimit * limit_N / length_N : 1.0;
}
double factor_to(double limit_N, const Vec3& force_N) {
  return is_far_below(force_N, limit_N) ? 1.0 : factor_to(limit_N, force_N.norm());
}

// Sets a rule's bit if its factor reduces the force.
double marked(double factor, GovernorRule rule, TickRecord& record) {
  if (factor < 1.0) record.rules |= rule;
  return factor;
}

}  // namespace

double SafetyGovernor::clamp_of(const DeviceDescription& device,
                                const std::optional<double>& max_force_N) noexcept {
  double clamp_N = std::numeric_limits<double>::infinity();
  if (device.moves_motors) clamp_N = Limits::kUnknownPeak_N;
  if (device.peak_force_N > 0.0) clamp_N = device.peak_force_N;
  // A negative limit would reverse the force.
  return std::max(0.0, std::min(clamp_N, max_force_N.value_or(clamp_N)));
}

SafetyGovernor::SafetyGovernor(const DeviceDescription& device, double clamp_N,
                               const GovernorSettings& settings) noexcept
    : moves_motors_(device.moves_motors),
      watches_energy_(device.moves_motors && settings.watches_energy),
      limits_motors_(device.moves_motors || device.motor_count > 0),
      clamp_N_(clamp_N),
      workspace_low_m_(device.workspace_low_m),
      workspace_high_m_(device.workspace_high_m),
      sensed_axes_(device.sensed_axes),
      motors_(motors_of(device)),
      path_(device.encoder_quantum_m),
      half_step_m_(device.moves_motors ? 0.5 * device.encoder_quantum_m : 0.0),
      mechanics_(assumed_mechanics(device)),
      control_(mechanics_, device.encoder_quantum_m),
      design_(settings.budgets),
      release_(device.encoder_quantum_m) {
  if (device.rate_Hz > 0.0) device_period_ns_ = nanoseconds(1.0 / device.rate_Hz);
  set_period(0);
  if (moves_motors_) begin_start();
}

const DeviceSample& SafetyGovernor::begin_tick(const DeviceSample& sample,
                                               const TickTime& time) noexcept {
  find_times(time);
  is_out_of_order_ = moves_motors_ && has_sample_ && sample.sequence < sample_.sequence;
  is_new_ = !has_sample_ || sample.sequence > sample_.sequence;
  const bool is_newest_good = is_new_ && sample.is_valid;
  sample_age_ns_ = is_newest_good ? 0 : sample_age_ns_ + step_ns_;
  if (is_newest_good && sample.time_ns != 0 && time.now_ns != 0) {
    sample_age_ns_ = std::max<std::int64_t>(0, time.now_ns - sample.time_ns);
  }
  if (is_out_of_order_) {
    sample_.asks_for_trip = sample.asks_for_trip;
    return sample_;
  }
  has_sample_ = true;
  sample_ = sample;
  return sample_;
}

void SafetyGovernor::find_times(const TickTime& time) noexcept {
  if (time.dt_s != dt_s_ && is_time_step(time.dt_s)) {
    dt_s_ = time.dt_s;
    set_period(nanoseconds(dt_s_));
  }
  const bool is_measured = time.now_ns != 0 && last_now_ns_ != 0;
  step_ns_ = is_measured ? std::max<std::int64_t>(0, time.now_ns - last_now_ns_) : period_ns_;
  last_now_ns_ = time.now_ns;
  late_ns_ = std::max(time.late_ns, step_ns_ - period_ns_);
  if (paused_at_ns_ != 0 && time.now_ns - paused_at_ns_ > step_ns_) {  // motors cool in a pause
    heat_.add(Vec3::Zero(), time.now_ns - paused_at_ns_ - step_ns_);
  }
  paused_at_ns_ = 0;
  now_ns_ += step_ns_;
  ramp_step_ns_ = std::min(step_ns_, longest_step_ns_);
}

void SafetyGovernor::set_period(std::int64_t period_ns) noexcept {
  period_ns_ = period_ns;
  longest_step_ns_ = longer_ns(0.0, Limits::kLongestStepPeriods, period_ns_);
  longest_age_ns_ = longer_ns(Limits::kStale_s, Limits::kStalePeriods, period_ns_);
  longest_late_ns_ = longer_ns(Limits::kLate_s, Limits::kLatePeriods, period_ns_);
  speed_.set_window(
      seconds(longer_ns(Limits::kSpeedWindow_s, Limits::kSpeedWindowPeriods, period_ns_)));
  if (!watches_energy_) return;
  least_delay_ = DelayTicks::of(mechanics_.delay.least_s, dt_s_);
  most_delay_ = DelayTicks::of(mechanics_.delay.most_s, dt_s_);
  control_.set_period(dt_s_);
}

void SafetyGovernor::govern(TickRecord& record, const ForceSources& sources) noexcept {
  record.rules = 0;
  Vec3 wanted_N = vec3(record.force_device_N);
  const bool has_bad_force = !wanted_N.allFinite() || (record.faults & kFaultNonFiniteForce) != 0 ||
                             (watches_energy_ && !vec3(record.full_force_device_N).allFinite());
  if (has_bad_force) {
    wanted_N.setZero();
    record.faults |= kFaultNonFiniteForce;
  }
  pushed_N_ = limits_motors_ ? motors_.part(wanted_N) : wanted_N;
  if (pushed_N_ != wanted_N) record.rules |= kRuleMotors;
  find_way(record);
  add_work(record);
  if (moves_motors_) {
    // Reading is much faster than an exchange, and there is rarely something to take.
    const bool rearms =
        rearm_.load(std::memory_order_relaxed) && rearm_.exchange(false, std::memory_order_acq_rel);
    if (rearms && is_tripped()) begin_start();
    watch_interruptions(record);
    watch_speed(record);
    if (has_bad_force) trip(TripReason::kBadForce, 0.0, 0.0, record);
    if (sample_.asks_for_trip) trip(TripReason::kDevice, 0.0, 0.0, record);
    watch_start(record);
  }
  const double factor = find_factor(record, sources);
  Vec3 force_N = factor < 1.0 ? Vec3(factor * pushed_N_) : pushed_N_;
  if (watches_energy_) {
    drive(force_N, record, sources, factor);
  } else if (moves_motors_) {
    limit_slew(force_N, record);
  }
  last_force_N_ = force_N;
  put(force_N, record.force_device_N);
}

void SafetyGovernor::pause() noexcept {
  if (last_now_ns_ != 0) paused_at_ns_ = last_now_ns_;
  last_now_ns_ = 0;  // the next tick is one period long
  last_force_N_.setZero();
  has_work_ = false;
  speed_.clear();
  if (!watches_energy_) {
    if (moves_motors_ && !is_tripped()) begin_start();
    return;
  }
  commanded_ = {};
  acted_N_.setZero();
  acted_late_N_.setZero();
  acted_ticks_ = 0;
  last_even_N_.setZero();
  last_missing_N_.setZero();
  last_effects_N_ = no_giving_forces();
  release_.stop();
  control_.lose_way();
  control_.forget_forces();
  if (!is_tripped()) begin_start();
}

// The rules bad sample, stale, order and late.
void SafetyGovernor::watch_interruptions(TickRecord& record) noexcept {
  is_interrupted_ = false;
  if (has_bad_sample(record)) {
    is_interrupted_ = true;
    record.rules |= kRuleBadSample;
  }
  if (sample_age_ns_ > longest_age_ns_) {
    is_interrupted_ = true;
    record.rules |= kRuleStale;
    const std::int64_t longest_ns = std::max(nanoseconds(Limits::kStaleTrip_s), longest_age_ns_);
    if (sample_age_ns_ > longest_ns) {
      trip(TripReason::kStale, seconds(sample_age_ns_), seconds(longest_ns), record);
    }
  }
  if (is_out_of_order_) record.rules |= kRuleOrder;
  if (late_ns_ > longest_late_ns_) {
    is_interrupted_ = true;
    record.rules |= kRuleLate;
    const bool is_very_late =
        late_ns_ > std::max(nanoseconds(Limits::kLateRestart_s), longest_late_ns_);
    if (is_very_late && !is_tripped()) begin_start();
  }
  is_eased_ = is_interrupted_ || (is_eased_ && ease_ns_ < nanoseconds(Limits::kEase_s));
  ease_ns_ = is_interrupted_ ? 0 : ease_ns_ + ramp_step_ns_;
}

// Counts the bad samples of the last kBadSamples_s, and trips if they are too many.
bool SafetyGovernor::has_bad_sample(TickRecord& record) noexcept {
  if ((record.faults & kFaultsWithoutForce) == 0) return false;
  // A ring: the next entry is the oldest of the last kMostBadSamples bad samples.
  bad_ns_[bad_samples_ % bad_ns_.size()] = now_ns_;
  ++bad_samples_;
  const std::int64_t first_ns = bad_ns_[bad_samples_ % bad_ns_.size()];
  if (bad_samples_ >= bad_ns_.size() && now_ns_ - first_ns <= nanoseconds(Limits::kBadSamples_s)) {
    trip(TripReason::kBadSamples, Limits::kMostBadSamples, Limits::kMostBadSamples - 1, record);
  }
  return true;
}

void SafetyGovernor::watch_speed(TickRecord& record) noexcept {
  const bool is_usable = is_new_ && (record.faults & kFaultsWithoutForce) == 0;
  if (is_usable) speed_.add(seconds(now_ns_ - sample_age_ns_), vec3(record.device_m));
  if (!speed_.may_exceed(Limits::kTopSpeed_m_per_s)) return;
  const auto speed = speed_.speed_m_per_s();
  if (!speed || *speed <= Limits::kTopSpeed_m_per_s) return;
  if (last_force_N_.norm() <= Limits::kMovingShare * clamp_N_) return;
  record.rules |= kRuleSpeed;
  trip(TripReason::kSpeed, *speed, Limits::kTopSpeed_m_per_s, record);
}

void SafetyGovernor::watch_start(const TickRecord& record) noexcept {
  if (status_.state == GovernorState::kWaits) {
    const auto speed = speed_.speed_m_per_s();
    const bool is_light = record.contact == 0 || pushed_N_.norm() < Limits::kStartForce_N;
    const bool is_calm =
        !is_interrupted_ && is_light && speed && *speed < Limits::kStartSpeed_m_per_s;
    calm_ns_ = is_calm ? calm_ns_ + ramp_step_ns_ : 0;
    if (calm_ns_ < nanoseconds(Limits::kCalm_s)) return;
    status_.state = GovernorState::kStarts;
    start_ns_ = 0;
  } else if (status_.state == GovernorState::kStarts) {
    start_ns_ += ramp_step_ns_;
    if (start_ns_ >= nanoseconds(Limits::kStart_s)) status_.state = GovernorState::kRuns;
  }
}

void SafetyGovernor::begin_start() noexcept {
  status_.state = GovernorState::kWaits;
  calm_ns_ = 0;
  release_.stop();
  control_.clear();
}

void SafetyGovernor::trip(TripReason reason, double value, double limit,
                          TickRecord& record) noexcept {
  if (is_tripped()) return;
  status_.state = GovernorState::kTripped;
  ++status_.trips;
  GovernorTrip& trip = status_.trip;
  trip = {reason, record.tick, record.time_s, value, limit, {}, {}};
  release_.stop();
  const bool is_trusted = reason == TripReason::kSpeed || reason == TripReason::kUnstable;
  if (watches_energy_ && is_trusted) release_.begin(last_force_N_);
  std::copy_n(record.device_m, 3, trip.device_m.begin());
  std::copy_n(record.force_device_N, 3, trip.wanted_N.begin());
}

// The smallest factor of all rules but the slew.
double SafetyGovernor::find_factor(TickRecord& record, const ForceSources& sources) noexcept {
  double factor = marked(factor_to(clamp_N_, pushed_N_), kRuleClamp, record);
  if (limits_motors_) {
    const double peaks = motors_.scale(pushed_N_);
    factor = std::min(factor, marked(peaks < 1.0 ? kBelowLimit * peaks : 1.0, kRulePeak, record));
  }
  if (!moves_motors_) return factor;
  factor = std::min(factor, marked(workspace_factor(record), kRuleWorkspace, record));
  if (is_eased_) factor = std::min(factor, marked(ease_share(), kRuleEase, record));
  if (watches_energy_) {
    const double soft = marked(control_.stiffness(), kRuleSoft, record);
    factor = std::min(factor, soft * marked(restart_factor(sources), kRuleRestart, record));
  }
  if (status_.state != GovernorState::kRuns) {
    const GovernorRule rule = is_tripped() ? kRuleTripped : kRuleStart;
    factor = std::min(factor, marked(start_share(), rule, record));
  }
  heat_share_ = 1.0;
  if (!watches_energy_ || !motors_.may_overload(pushed_N_)) return factor;
  heat_share_ = marked(heat_.factor(motors_.loads(factor * pushed_N_)), kRuleHeat, record);
  return heat_share_ * factor;
}

// The share of the force that an interruption has left.
double SafetyGovernor::ease_share() const noexcept {
  return is_eased_ ? seconds(ease_ns_) / Limits::kEase_s : 1.0;
}

// The share of the force that the state allows.
double SafetyGovernor::start_share() const noexcept {
  switch (status_.state) {
    case GovernorState::kRuns:
      return 1.0;
    case GovernorState::kStarts:
      return seconds(start_ns_) / Limits::kStart_s;
    case GovernorState::kWaits:
    case GovernorState::kTripped:
      return 0.0;
  }
  return 0.0;
}

// 1 in the workspace, 0 outside a box of 1 + kFadeShare times its size. An axis along which the
// workspace has no extent is not limited.
double SafetyGovernor::workspace_factor(const TickRecord& record) const noexcept {
  double factor = 1.0;
  for (int k = 0; k < sensed_axes_; ++k) {
    const auto n = static_cast<std::size_t>(k);
    const double half_m = 0.5 * (workspace_high_m_[n] - workspace_low_m_[n]);
    if (!(half_m > 0.0)) continue;
    const double middle_m = workspace_low_m_[n] + half_m;
    const double from_middle_m = std::abs(record.device_m[k] - middle_m);
    if (from_middle_m <= half_m) continue;
    const double beyond = from_middle_m / half_m - 1.0;
    factor = std::min(factor, std::max(0.0, 1.0 - beyond / Limits::kFadeShare));
  }
  return factor;
}

void SafetyGovernor::limit_slew(Vec3& force_N, TickRecord& record) const noexcept {
  const double growth_N = Limits::kSlew_N_per_s * seconds(ramp_step_ns_);
  // No force grows by more than the length of its change.
  if (is_far_below(force_N - last_force_N_, growth_N)) return;
  const double length_N = force_N.norm();
  if (length_N == 0.0) return;
  const double before_N = std::max(0.0, last_force_N_.dot(force_N) / length_N);
  const double factor = factor_to(before_N + growth_N, length_N);
  if (factor < 1.0) force_N *= marked(factor, kRuleSlew, record);
}

}  // namespace palpate
