#include "haptics/passivity_control.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptics/nanoseconds.h"

namespace palpate {
namespace {

// A change of a force by less than half of its digits is rounding. A step of an encoder is far
// more.
constexpr double kRounding2 = std::numeric_limits<double>::epsilon();

// The square of the part of a way along the direction of a force, as a fraction, which saves a
// division.
struct AlongSquare {
  double square;  // (way . force)^2
  double force2;

  AlongSquare(const Vec3& way_m, const Vec3& force_N) : force2(force_N.squaredNorm()) {
    const double along = way_m.dot(force_N);
    square = along * along;
  }
};

// The larger one of two, divided by a time; 0 for no force.
double larger_per_s(const AlongSquare& a, const AlongSquare& b, double time_s) {
  const bool is_a = a.force2 > 0.0 && a.square * b.force2 >= b.square * a.force2;
  const AlongSquare& larger = is_a ? a : b;
  return larger.force2 > 0.0 ? larger.square / (larger.force2 * time_s) : 0.0;
}

}  // namespace

void PassivityControl::set_period(double period_s) noexcept {
  period_s_ = period_s;
  delays_ = {DelayTicks::of(device_.delay.least_s, period_s),
             DelayTicks::of(device_.delay.most_s, period_s)};
  window_ = static_cast<std::size_t>(controller_velocity_ticks(period_s));
  most_damping_ = palpate::largest_damping_Ns_per_m(device_.mass_kg, device_.delay.most_s, period_s,
                                                    static_cast<int>(window_));
  forgotten_ = std::min(1.0, period_s / PassivityLimits::kForget_s);
  averaged_ = std::min(1.0, period_s / PassivityLimits::kAverage_s);
  lose_way();
  forget_forces();
}

void PassivityControl::clear() noexcept {
  count_ = 0;
  ends_ = {};
  motion_Js_per_Ns_ = 0.0;
  forget_forces();
  is_active_ = has_swung_ = false;
  stiffness_ = 1.0;
  unstable_s_ = 0.0;
  swing_.clear();
  span_.clear();
}

void PassivityControl::forget_forces() noexcept {
  forces_ = {};
  dampings_ = {};
  booked_J_ = {};
  damped_ticks_ = 0;
  since_ = {};
  held_N_.setZero();
}

// Adds an energy to both accounts.
void PassivityControl::pay(double energy_J) noexcept {
  for (End& end : ends_) end.account_J += energy_J;
}

// The window of the velocity in samples that were as far apart as longest_hold_s.
std::size_t PassivityControl::samples_of_window(double longest_hold_s) const noexcept {
  if (!(longest_hold_s > period_s_)) return window_;
  const double window_s = static_cast<double>(window_) * period_s_;
  return static_cast<std::size_t>(std::max(1.0, std::round(window_s / longest_hold_s)));
}

// For such samples, which make the velocity older: by what they are late, and by half of what the
// window is longer.
double PassivityControl::held_damping(double longest_hold_s) const noexcept {
  if (!(longest_hold_s > period_s_)) return most_damping_;
  const double longer_s = static_cast<double>(samples_of_window(longest_hold_s)) * longest_hold_s -
                          static_cast<double>(window_) * period_s_;
  const double late_s = longest_hold_s - period_s_ + 0.5 * std::max(0.0, longer_s);
  return palpate::largest_damping_Ns_per_m(device_.mass_kg, device_.delay.most_s + late_s,
                                           period_s_, static_cast<int>(window_));
}

Vec3 PassivityControl::damping_N(const Tick& tick) noexcept {
  along_m_per_s_.setZero();
  held_N_.setZero();
  const SinceSample since = std::exchange(since_, {});
  if (!tick.has_way) count_ = 0;
  counted_damping_ = tick.is_disturbed ? 0.0 : device_.damping_Ns_per_m;
  samples_with_force_ = tick.force_N.isZero(0.0) ? 0 : samples_with_force_ + 1;
  const std::size_t before = newest_;
  newest_ = (newest_ + 1) % kPositions;
  positions_m_[newest_] = tick.p_device_m;
  times_ns_[newest_] = tick.now_ns;
  count_ = std::min(count_ + 1, kPositions);
  if (count_ < 2 || !(period_s_ > 0.0)) return Vec3::Zero();
  const std::size_t samples = std::min(samples_of_window(tick.longest_hold_s), count_ - 1);
  const std::size_t then = (newest_ + kPositions - samples) % kPositions;
  const Vec3 changed_N = tick.force_N - forces_of_samples_N_[then];
  if (has_steps()) learn_span(tick);
  observe(tick, tick.p_device_m - positions_m_[before], since);
  soften(tick);
  const double least_N =
      tick.stiffness_N_per_m *
      std::max(PassivityLimits::kFeltSwing_m, PassivityLimits::kSwingSteps * quantum_m_);
  if (least_N > 0.0) swing_.add(tick.force_N, least_N, tick.now_ns);
  if (swing_rad_per_s() > 0.0) has_swung_ = true;
  const double known = has_steps() && samples_with_force_ > 0 ? known_damping(tick) : 0.0;
  if (!is_active_ && !has_swung_ && known == 0.0) return Vec3::Zero();
  const double change2 = changed_N.squaredNorm();
  if ((change2 == 0.0 && !has_steps()) || tick.force_N.isZero(0.0)) return Vec3::Zero();
  const double window_s = seconds(tick.now_ns - times_ns_[then]);
  if (!(window_s > 0.0)) return Vec3::Zero();
  const Vec3 velocity = (tick.p_device_m - positions_m_[then]) / window_s;
  // (v.u) u without a root.
  const Vec3 along =
      has_steps() ? span_.part(velocity) : Vec3(velocity.dot(changed_N) / change2 * changed_N);
  along_m_per_s_ = along;
  const double most = held_damping(tick.longest_hold_s);
  const double damping = std::min(most, std::max(known, wanted_damping(along.norm())));
  held_N_ = -damping * along;
  return held_N_;
}

void PassivityControl::learn_span(const Tick& tick) noexcept {
  if (seconds(tick.now_ns - last_force_ns_) > PassivityLimits::kRest_s) span_.clear();
  const Vec3 change_N = tick.force_N - forces_.back(0);
  const bool is_rounding = change_N.squaredNorm() <= kRounding2 * tick.force_N.squaredNorm();
  if (!is_rounding) span_.add(change_N);
}

// Leak and motion of a swing of some steps are mostly rounding. But a spring K leaks K (tau + T /
// 2) per square of speed, if it is not softer along the motion than it states.
double PassivityControl::known_damping(const Tick& tick) const noexcept {
  const double stated = tick.stiffness_N_per_m;
  const double late_s = device_.delay.most_s + 0.5 * period_s_;
  if (!(stated * late_s > device_.damping_Ns_per_m)) return 0.0;
  // The way in the air before the contact says nothing.
  const std::size_t most = std::min(count_ - 1, samples_with_force_ - 1);
  const double wanted = PassivityLimits::kAverage_s / std::max(period_s_, tick.longest_hold_s);
  const auto samples = static_cast<std::size_t>(std::min(wanted, static_cast<double>(most)));
  const std::size_t then = (newest_ + kPositions - samples) % kPositions;
  const Vec3 changed_N =
      samples > 0 ? Vec3(tick.force_N - forces_of_samples_N_[then]) : Vec3::Zero();
  const Vec3 way_m = tick.p_device_m - positions_m_[then];
  const double change_N = changed_N.norm();
  const double step_N = stated * quantum_m_;
  double stiffness = stated;
  if (change_N > PassivityLimits::kSureSteps * step_N) {
    const double work_J = std::abs(changed_N.dot(way_m));
    stiffness = std::min(stated, change_N * (change_N + step_N) / work_J);
  }
  const double damping = (1.0 + PassivityLimits::kMargin) * stiffness * late_s - counted_damping_;
  return std::max(0.0, damping);
}

void PassivityControl::observe(const Tick& tick, const Vec3& way_m,
                               const SinceSample& since) noexcept {
  const Vec3& last_N = forces_.back(0);
  const double share = 1.0 / std::max(1, since.ticks);
  const std::array<Vec3, 2> acting_N = {share * since.acting_N[0], share * since.acting_N[1]};
  pay(tick.given_J);
  const bool has_force =
      !tick.force_N.isZero(0.0) || !acting_N[1].isZero(0.0) || !last_N.isZero(0.0);
  if (has_force) {
    const Vec3 even_N = 0.5 * (last_N + tick.force_N);
    const double motion = has_steps() ? span_.part(way_m).dot(way_m) / tick.way_s
                                      : larger_per_s({way_m, tick.force_N - last_N},
                                                     {way_m, acting_N[1] - even_N}, tick.way_s);
    pay(share * since.damping_N.dot(way_m) - since.booked_J);
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      const double leak_J = (acting_N[n] - even_N).dot(way_m);
      ends_[n].account_J += leak_J - counted_damping_ * motion;
      ends_[n].leak_J += leak_J - averaged_ * ends_[n].leak_J;
    }
    motion_Js_per_Ns_ += motion - averaged_ * motion_Js_per_Ns_;
    last_force_ns_ = tick.now_ns;
  }
  for (End& end : ends_) {
    end.account_J = std::max(end.account_J, -PassivityLimits::kMostCredit_J);
    if (end.account_J > 0.0) end.account_J -= forgotten_ * end.account_J;
  }
  if (account_J() > 0.0) {
    is_active_ = true;
  } else if (account_J() <= -PassivityLimits::kMostCredit_J) {
    is_active_ = false;
  }
}

// Makes the force softer while the account is too high, and restores it after the contact.
void PassivityControl::soften(const Tick& tick) noexcept {
  judged_J_ = account_J();
  if (judged_J_ > PassivityLimits::kSoften_J) {
    if (stiffness_ > PassivityLimits::kLeastStiffness) {
      stiffness_ =
          std::max(PassivityLimits::kLeastStiffness,
                   stiffness_ * (1.0 - std::min(0.5, period_s_ / PassivityLimits::kSoftening_s)));
    } else if (!tick.force_N.isZero(0.0)) {  // without a force, nothing grows
      unstable_s_ += period_s_;
    }
    return;
  }
  unstable_s_ = 0.0;
  if (seconds(tick.now_ns - last_force_ns_) > PassivityLimits::kRest_s) {
    stiffness_ = 1.0;
    has_swung_ = false;
    for (End& end : ends_) end.leak_J = 0.0;
    motion_Js_per_Ns_ = 0.0;
  }
}

// Of a swing that the loop keeps up.
double PassivityControl::swing_rad_per_s() const noexcept {
  const double own_J = PassivityLimits::kSwingLeak * device_.damping_Ns_per_m * motion_Js_per_Ns_;
  return is_active_ || leak_J() > own_J ? swing_.swing_rad_per_s() : 0.0;
}

double PassivityControl::wanted_damping(double speed_m_per_s) const noexcept {
  double damping = 0.0;
  if (is_active_ || has_swung_) {
    if (motion_Js_per_Ns_ > 0.0) {
      damping = std::max(
          0.0, (1.0 + PassivityLimits::kMargin) * leak_J() / motion_Js_per_Ns_ - counted_damping_);
    }
    if (account_J() > 0.0) {
      damping += account_J() / (speed_m_per_s * speed_m_per_s * PassivityLimits::kRepay_s);
    }
  }
  const double of_swing =
      2.0 * PassivityLimits::kSwingDamping * device_.mass_kg * swing_rad_per_s();
  return std::max(damping, of_swing);
}

void PassivityControl::command(const Vec3& force_N, const Vec3& damping_N) noexcept {
  forces_.push(force_N);
  forces_of_samples_N_[newest_] = force_N;
  ++since_.ticks;
  for (std::size_t n = 0; n < delays_.size(); ++n) {
    since_.acting_N[n] += forces_.acting_N(delays_[n]);
  }
  if (!damping_N.isZero(0.0)) {
    damped_ticks_ = booked_J_.size();
  } else if (damped_ticks_ == 0) {
    return;
  } else {
    --damped_ticks_;
  }
  dampings_.push(damping_N);
  booked_ = (booked_ + 1) % booked_J_.size();
  booked_J_[booked_] = damping_N.dot(along_m_per_s_) * period_s_;
  pay(booked_J_[booked_]);
  since_.damping_N += dampings_.acting_N(delays_[1]);
  since_.booked_J += booked_J_[(booked_ + booked_J_.size() - delays_[1].whole) % booked_J_.size()];
}

}  // namespace palpate
