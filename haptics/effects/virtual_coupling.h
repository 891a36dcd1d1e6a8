#pragma once

// The virtual coupling: a spring and a damper in parallel between proxy and device point.

#include <algorithm>

#include "geometry/base/types.h"
#include "haptics/effects/velocity_estimator.h"

namespace palpate {

// The coupling's parameters. The defaults are those of the library, the program and the report. On
// a light desktop device (viscous friction b = 0.5 N s/m) at T = 1 ms, a wall is passive up to K =
// 2 (b - B) / T (engine/devices/stability_limits.h). Without a damper, this limit is 1000 N/m; with
// B of 0.5 N s/m or more, no wall is passive.
struct CouplingSettings {
  double stiffness_N_per_m = 1000.0;  // K >= 0
  double damping_Ns_per_m = 0.0;      // B >= 0
  VelocitySettings velocity = {};     // estimates the lag's velocity for the damper
};

// Returns the coupling force on the hand, F = K (p - g) + B u, in newtons and scene axes, where p
// is the proxy and g the goal (Lecuyer et al. 2005, section 3: "a spring and a damper in
// parallel").
//
// The paper does not say which velocity the damper acts on. Here u is only the component of
// d(p - g)/dt along the directions in which the surface presses on the proxy
// (ProxyState::pressed_part). Motion along the surface is not damped, so that a freely sliding
// proxy follows the hand without resistance. The lag turns as the proxy moves around a surface. A
// damper on the whole lag would therefore push the hand forward: a hand that moves at speed v at
// penetration depth d on a sphere of radius r would receive the force B d v / r, for d much smaller
// than r. If friction holds the proxy at rest, u is the whole d(p - g)/dt.
//
// The force is never attractive: a component that pulls along the contact normal N is removed, so
// that F.N >= 0.
//
// lag_m: p - g. damped_m_per_s: u. normal: unit contact normal N, or zero if several normals
// cancel. The function uses only K and B from the settings. No state; safe on any thread.
inline Vec3 coupling_force_N(const CouplingSettings& settings, const Vec3& lag_m,
                             const Vec3& damped_m_per_s, const Vec3& normal) noexcept {
  Vec3 force = settings.stiffness_N_per_m * lag_m + settings.damping_Ns_per_m * damped_m_per_s;
  force += std::max(0.0, -force.dot(normal)) * normal;
  return force;
}

// The coupling of one haptic loop, which remembers the lags of the last ticks. Thread-safety: one
// thread owns it, and the haptic thread may be that thread.
class VirtualCoupling {
 public:
  explicit VirtualCoupling(const CouplingSettings& settings)
      : settings_(settings),
        is_one_tick_(settings.velocity.window_ticks <= 1),
        estimator_(settings.velocity) {}

  // Returns d(p - g)/dt, estimated by the method of the settings; zero on the first tick of a
  // contact. lag_m: proxy minus goal. By default the estimate is the backward difference of one
  // tick. With this difference, the damper dissipates B |dl|^2 / T in each tick, which is never
  // negative; dl is the change of the lag in the tick. A longer window has less noise, but returns
  // some of that energy. Effects that use a velocity of their own (viscosity) keep the difference
  // of one tick, so that their dissipation stays exact.
  Vec3 lag_rate_m_per_s(const Vec3& lag_m, double dt_s) noexcept {
    Vec3 rate = Vec3::Zero();
    if (!is_one_tick_) [[unlikely]] {
      rate = estimator_.add(lag_m, dt_s);
    } else if (had_contact_) {
      rate = (lag_m - last_lag_m_) / dt_s;
    }
    had_contact_ = true;
    last_lag_m_ = lag_m;
    return rate;
  }

  // Changes K and B, both finite and >= 0. The lags of the last ticks are kept.
  void set(double stiffness_N_per_m, double damping_Ns_per_m) noexcept {
    settings_.stiffness_N_per_m = stiffness_N_per_m;
    settings_.damping_Ns_per_m = damping_Ns_per_m;
  }

  // See coupling_force_N().
  Vec3 force_N(const Vec3& lag_m, const Vec3& damped_m_per_s, const Vec3& normal) const noexcept {
    return coupling_force_N(settings_, lag_m, damped_m_per_s, normal);
  }

  // Call this in a tick without contact, or if the next tick must not form a difference with the
  // lag of this one.
  void reset() noexcept {
    had_contact_ = false;
    estimator_.reset();
  }

 private:
  CouplingSettings settings_;
  bool is_one_tick_;
  bool had_contact_ = false;
  Vec3 last_lag_m_ = Vec3::Zero();
  VelocityEstimator estimator_;  // for windows of more than one tick
};

}  // namespace palpate
