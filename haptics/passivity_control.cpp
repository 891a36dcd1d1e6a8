#include "haptics/passivity_control.h"

#include <algorithm>
#include <cmath>

#include "haptics/nanoseconds.h"

namespace palpate {
namespace {

// The square of the part of a way along the direction of a force; 0 for no force.
double along2(const Vec3& way_m, const Vec3& force_N) {
  const double force2 = force_N.squaredNorm();
  const double along = way_m.dot(force_N);
  return force2 > 0.0 ? along * along / force2 : 0.0;
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
}

void PassivityControl::forget_forces() noexcept {
  forces_ = {};
  dampings_ = {};
  booked_J_ = {};
  held_N_.setZero();
}

// Adds an energy to both accounts.
void PassivityControl::pay(double energy_J) noexcept {
  for (End& end : ends_) end.account_J += energy_J;
}

Vec3 PassivityControl::damping_N(const Tick& tick) noexcept {
  along_m_per_s_.setZero();
  held_N_.setZero();
  if (!tick.has_way) count_ = 0;
  held_damping_ = most_damping_;
  if (tick.longest_hold_s > period_s_) {
    held_damping_ = palpate::largest_damping_Ns_per_m(
        device_.mass_kg, device_.delay.most_s + tick.longest_hold_s - period_s_, period_s_,
        static_cast<int>(window_));
  }
  counted_damping_ = tick.is_disturbed ? 0.0 : device_.damping_Ns_per_m;
  const Vec3 before_m = positions_m_[newest_];
  newest_ = (newest_ + 1) % kPositions;
  positions_m_[newest_] = tick.p_device_m;
  times_ns_[newest_] = tick.now_ns;
  count_ = std::min(count_ + 1, kPositions);
  if (count_ < 2 || !(period_s_ > 0.0)) return Vec3::Zero();
  const std::size_t ticks = std::min(window_, count_ - 1);
  const Vec3 changed_N = tick.force_N - forces_.back(ticks - 1);
  observe(tick, tick.p_device_m - before_m);
  soften(tick);
  const double least_N =
      tick.stiffness_N_per_m *
      std::max(PassivityLimits::kFeltSwing_m, PassivityLimits::kSwingSteps * quantum_m_);
  if (least_N > 0.0) swing_.add(tick.force_N, least_N, tick.now_ns);
  if (swing_rad_per_s() > 0.0) has_swung_ = true;
  if (!is_active_ && !has_swung_) return Vec3::Zero();
  const double change2 = changed_N.squaredNorm();
  if (change2 == 0.0 || tick.force_N.isZero(0.0)) return Vec3::Zero();
  const std::size_t then = (newest_ + kPositions - ticks) % kPositions;
  const double window_s = seconds(tick.now_ns - times_ns_[then]);
  if (!(window_s > 0.0)) return Vec3::Zero();
  const Vec3 velocity = (tick.p_device_m - positions_m_[then]) / window_s;
  // (v.u) u without a root.
  const Vec3 along = velocity.dot(changed_N) / change2 * changed_N;
  along_m_per_s_ = along;
  held_N_ = -wanted_damping(along.norm()) * along;
  return held_N_;
}

void PassivityControl::observe(const Tick& tick, const Vec3& way_m) noexcept {
  const Vec3& last_N = forces_.back(0);
  const std::array<Vec3, 2> acting_N = {forces_.acting_N(delays_[0]), forces_.acting_N(delays_[1])};
  pay(tick.given_J);
  const bool has_force =
      !tick.force_N.isZero(0.0) || !acting_N[1].isZero(0.0) || !last_N.isZero(0.0);
  if (has_force) {
    const Vec3 even_N = 0.5 * (last_N + tick.force_N);
    const double motion =
        std::max(along2(way_m, tick.force_N - last_N), along2(way_m, acting_N[1] - even_N)) /
        tick.way_s;
    const std::size_t acting = (booked_ + booked_J_.size() - delays_[1].whole) % booked_J_.size();
    pay(dampings_.acting_N(delays_[1]).dot(way_m) - booked_J_[acting]);
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
  if (account_J() > PassivityLimits::kSoften_J) {
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
  return std::min(held_damping_, std::max(damping, of_swing));
}

void PassivityControl::command(const Vec3& force_N, const Vec3& damping_N) noexcept {
  forces_.push(force_N);
  dampings_.push(damping_N);
  booked_ = (booked_ + 1) % booked_J_.size();
  booked_J_[booked_] = damping_N.dot(along_m_per_s_) * period_s_;
  pay(booked_J_[booked_]);
}

}  // namespace palpate
