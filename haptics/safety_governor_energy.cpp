// The energy that the motors give: what the governor sums, and what it does about it.

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/nanoseconds.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"

namespace palpate {
namespace {

// A way without samples of more than this number of periods, of the ticks or of the device, is a
// gap. Two periods are a device that samples just after a tick.
constexpr double kGapPeriods = 2.5;

// How long an interruption counts for PassivityControl.
constexpr std::int64_t kDisturbed_ns = 1'000'000'000;

constexpr double kGlitchSpeed_m_per_s = 2.0 * GovernorLimits::kTopSpeed_m_per_s;

}  // namespace

// The way since the last good sample, and the mean of the forces that acted on it.
void SafetyGovernor::find_way(const TickRecord& record) noexcept {
  has_way_ = is_gap_ = false;
  way_m_.setZero();
  sensed_way_m_.setZero();
  way_work_J_ = 0.0;
  const bool is_bad = (record.faults & kFaultsWithoutForce) != 0;
  if (!watches_energy_) {
    if (is_bad) has_work_ = false;
    if (!is_bad && has_work_) way_m_ = vec3(record.device_m) - work_device_m_;
    sensed_way_m_ = way_m_;
    has_way_ = !is_bad && has_work_;
    return;
  }
  acted_N_ += commanded_.acting_N(least_delay_);
  acted_late_N_ += commanded_.acting_N(most_delay_);
  acted_ns_ += step_ns_;
  ++acted_ticks_;
  if (is_bad || !is_new_) return;
  has_way_ = has_work_;
  if (!has_work_) path_.clear();
  const Vec3 last_place_m = place_m_;
  place_m_ = path_.add(vec3(record.device_m), seconds(acted_ns_));
  if (!has_work_) return;
  sensed_way_m_ = vec3(record.device_m) - work_device_m_;
  way_m_ = place_m_ - last_place_m;
  way_ns_ = acted_ns_;
  if (is_glitch()) {
    has_way_ = false;
    way_m_.setZero();
    sensed_way_m_.setZero();
    path_.clear();
    place_m_ = vec3(record.device_m);
  }
  is_gap_ = static_cast<double>(acted_ns_) >
            kGapPeriods * static_cast<double>(std::max(period_ns_, device_period_ns_));
  // Of the last kDisturbed_ns.
  if (acted_ns_ >= longest_hold_ns_ || now_ns_ - longest_hold_since_ns_ > kDisturbed_ns) {
    longest_hold_ns_ = acted_ns_;
    longest_hold_since_ns_ = now_ns_;
  }
}

// The device holds a force until the next one acts: the work is that of the forces that acted along
// the way.
void SafetyGovernor::add_work(const TickRecord& record) noexcept {
  const bool is_settled =
      (record.faults & kFaultsWithoutForce) == 0 && (is_new_ || !watches_energy_);
  if (!is_settled) return;
  if (has_way_ && !watches_energy_) {
    const double work_J = last_force_N_.dot(way_m_);
    status_.given_J += work_J;
    status_.given_late_J += work_J;
    status_.given_by_design_J += work_masked_N_.dot(way_m_);
  } else if (has_way_) {
    const double share = 1.0 / acted_ticks_;
    way_work_J_ = share * acted_N_.dot(way_m_);
    status_.given_J += way_work_J_;
    status_.given_late_J += share * acted_late_N_.dot(way_m_);
    status_.given_by_design_J += work_masked_N_.dot(way_m_);
  }
  acted_N_.setZero();
  acted_late_N_.setZero();
  acted_ticks_ = 0;
  acted_ns_ = 0;
  has_work_ = true;
  work_device_m_ = vec3(record.device_m);
  work_masked_N_ = pushed_N_ - vec3(record.full_force_device_N);
}

// No hand moves as fast: the sample is wrong, and no work was done.
bool SafetyGovernor::is_glitch() const noexcept {
  const double most_m = kGlitchSpeed_m_per_s * seconds(std::max(way_ns_, period_ns_));
  return sensed_way_m_.squaredNorm() > most_m * most_m;
}

double SafetyGovernor::restart_factor(const ForceSources& sources) noexcept {
  SpringRestart::Tick tick;
  tick.stiffness_N_per_m = control_.stiffness() * sources.stiffness_N_per_m;
  tick.spring_N = tick.stiffness_N_per_m * sources.lag_m;
  tick.way_m = sensed_way_m_.norm();
  tick.work_J = -way_work_J_;
  tick.is_gap = is_gap_;
  tick.is_interrupted = is_interrupted_;
  tick.nodes_moved = sources.nodes_moved;
  tick.share = std::min(start_share(), ease_share());
  tick.owed_J = std::max(0.0, control_.account_J());
  tick.step_s = seconds(ramp_step_ns_);
  return restart_.factor(tick);
}

// The last steps before the motors of a device that moves them.
void SafetyGovernor::drive(Vec3& force_N, TickRecord& record, const ForceSources& sources,
                           double factor) noexcept {
  if (!is_tripped()) {
    control(force_N, record, sources, factor);
    if (control_.is_unstable()) {
      trip(TripReason::kUnstable, control_.judged_J(), PassivityLimits::kSoften_J, record);
      record.rules |= kRuleTripped;
    }
  }
  if (is_tripped()) {
    force_N = released(record);
    control_.lose_way();
    control_.command(Vec3::Zero(), Vec3::Zero());
    last_even_N_.setZero();
    last_missing_N_.setZero();
  }
  heat_.add(motors_.loads(force_N), step_ns_);
  if (half_step_m_ > 0.0) {
    status_.encoder_J += half_step_m_ * (force_N - commanded_.back(0)).lpNorm<1>();
  }
  commanded_.push(force_N);
  status_.given_by_source_J = design_.given_J();
  status_.account_J = control_.account_J();
}

// Adds the damping of the passivity controller, and limits the growth of the sum.
void SafetyGovernor::control(Vec3& force_N, TickRecord& record, const ForceSources& sources,
                             double factor) noexcept {
  const Vec3 even_N = force_N;
  const double beyond_J = beyond_budgets_J(record, sources, even_N, factor);
  if (is_interrupted_ || is_gap_) interrupted_ns_ = now_ns_;
  // A vibration has its own budget, and what the delay makes of it does not swing by itself.
  Vec3 watched_N = even_N;
  if (sources.has_effects) watched_N -= factor * motors_.part(sources.effects_N[0]);
  Vec3 damping_N = Vec3::Zero();
  if ((record.faults & kFaultsWithoutForce) != 0 || is_interrupted_) {
    control_.lose_way();
  } else if (!is_new_) {
    damping_N = control_.held_damping_N();
  } else {
    PassivityControl::Tick tick;
    tick.p_device_m = place_m_;
    tick.has_way = has_way_ && way_ns_ > 0;
    tick.way_s = seconds(way_ns_);
    tick.force_N = watched_N;
    tick.stiffness_N_per_m = sources.stiffness_N_per_m;
    tick.given_J = std::isfinite(beyond_J) ? beyond_J : 0.0;
    tick.longest_hold_s = seconds(longest_hold_ns_);
    tick.is_disturbed = now_ns_ - interrupted_ns_ < kDisturbed_ns;
    tick.now_ns = now_ns_;
    damping_N = control_.damping_N(tick);
  }
  if (!damping_N.isZero(0.0)) {
    record.rules |= kRuleDamping;
    damping_N = motors_.part(damping_N);
    // The damper never pulls the hand into a surface.
    const double against = -damping_N.dot(even_N);
    const double even2 = even_N.squaredNorm();
    if (against > even2) damping_N *= even2 / against;
    // A load beyond all numbers has left nothing of the force.
    const Vec3 warm_N = heat_share_ > 0.0 ? Vec3(even_N / heat_share_) : even_N;
    force_N = cooled(limited(warm_N + damping_N), record);
  }
  limit_slew(force_N, record);
  // What the rules have left of both parts.
  const Vec3 sum_N = even_N + damping_N;
  const double sum2 = sum_N.squaredNorm();
  const double left = sum2 > 0.0 ? force_N.dot(sum_N) / sum2 : 1.0;
  control_.command(left * watched_N, left * damping_N);
  last_even_N_ = even_N;
}

// What the sources have given in this tick beyond their budgets.
double SafetyGovernor::beyond_budgets_J(const TickRecord& record, const ForceSources& sources,
                                        const Vec3& even_N, double factor) noexcept {
  Vec3 missing_N = Vec3::Zero();
  if ((record.faults & kFaultNonFiniteForce) == 0) {
    missing_N = pushed_N_ - vec3(record.full_force_device_N);
  }
  missing_N *= factor;
  GivingForces effects_N = no_giving_forces();
  const bool have_effects = sources.has_effects || had_effects_;
  if (sources.has_effects) {
    for (std::size_t n = 0; n < effects_N.size(); ++n) effects_N[n] = factor * sources.effects_N[n];
  }
  nodes_J_ += factor * sources.nodes_J;
  double beyond_J = 0.0;
  if (has_way_) {
    const auto work_J = [&](const Vec3& before, const Vec3& now) {
      return 0.5 * (before + now).dot(way_m_);
    };
    GivenByDesign::Work work;
    work.even_J = work_J(last_even_N_, even_N);
    work.motors_J = work_J(last_missing_N_, missing_N);
    for (std::size_t n = 0; have_effects && n < effects_N.size(); ++n) {
      work.effects_J[n] = work_J(last_effects_N_[n], effects_N[n]);
    }
    work.nodes_J = std::exchange(nodes_J_, 0.0);
    if (sources.stiffness_N_per_m > 0.0) {
      work.most_stored_J = 0.5 * sources.stiffness_N_per_m * sources.lag_m * sources.lag_m;
    }
    work.in_contact = record.contact != 0;
    work.step_s = seconds(ramp_step_ns_);
    beyond_J = design_.add(work);
  }
  last_missing_N_ = missing_N;
  if (have_effects) last_effects_N_ = effects_N;
  had_effects_ = sources.has_effects;
  return beyond_J;
}

// A force that no motor and not the clamp must shorten.
Vec3 SafetyGovernor::limited(const Vec3& force_N) const noexcept {
  double factor = motors_.scale(force_N);
  const double length_N = force_N.norm();
  if (length_N > clamp_N_) factor = std::min(factor, clamp_N_ / length_N);
  return factor < 1.0 ? Vec3(kBelowLimit * factor * force_N) : force_N;
}

// A force that no motor is too warm for.
Vec3 SafetyGovernor::cooled(const Vec3& force_N, TickRecord& record) const noexcept {
  if (!motors_.may_overload(force_N)) return force_N;
  const double heat = heat_.factor(motors_.loads(force_N));
  if (!(heat < 1.0)) return force_N;
  record.rules |= kRuleHeat;
  return heat * force_N;
}

// The force after a trip.
Vec3 SafetyGovernor::released(TickRecord& record) noexcept {
  if (is_interrupted_ || sample_.asks_for_trip || (record.faults & kFaultNonFiniteForce) != 0) {
    release_.stop();
  }
  if (!release_.is_active()) return Vec3::Zero();
  const bool has_just_tripped = status_.trip.tick == record.tick;
  Vec3 force_N = cooled(
      limited(release_.force(sensed_way_m_, has_just_tripped ? 0 : step_ns_, motors_)), record);
  limit_slew(force_N, record);
  if (!force_N.isZero(0.0)) record.rules |= kRuleRelease;
  return force_N;
}

}  // namespace palpate
