#pragma once

// The spring and damper in parallel between proxy and device point.

#include <algorithm>

#include "geometry/base/types.h"
#include "haptics/effects/velocity_estimator.h"

namespace palpate {

// The defaults of the library, the program and the report. On a light desktop device (viscous
// friction b = 0.5 N s/m) at T = 1 ms a wall is passive up to K = 2 (b - B) / T: 1000 N/m without a
// damper, and nothing from B = 0.5 N s/m on (engine/devices/stability_limits.h).
struct CouplingSettings {
  double stiffness_N_per_m = 1000.0;  // K >= 0
  double damping_Ns_per_m = 0.0;      // B >= 0
  VelocitySettings velocity = {};     // of the lag, for the damper
};

// F = K (p - g) + B u in the scene frame, acting on the hand; p the proxy, g the goal
// (Lecuyer et al. 2005, section 3: "a spring and a damper in parallel"). The paper does not say
// what the damper acts on. Here u is the part of d(p - g)/dt against which the surface presses: a
// proxy that slides freely follows the hand for nothing, and a damper on all of the lag, which
// turns as the proxy goes round a surface, would push the hand along: B d v^2 / r on a sphere of
// radius r. Never attractive: a part that pulls along the contact normal is left out, so F.N >= 0.
//
// lag_m: p - g. damped_m_per_s: u. normal: unit contact normal, or zero where several cancel. K and
// B are all that counts of the settings. Safe on the haptic thread.
inline Vec3 coupling_force_N(const CouplingSettings& settings, const Vec3& lag_m,
                             const Vec3& damped_m_per_s, const Vec3& normal) noexcept {
  Vec3 force = settings.stiffness_N_per_m * lag_m + settings.damping_Ns_per_m * damped_m_per_s;
  force += std::max(0.0, -force.dot(normal)) * normal;
  return force;
}

// The coupling of one haptic loop, with what it remembers of the lag. Safe on the haptic thread.
class VirtualCoupling {
 public:
  explicit VirtualCoupling(const CouplingSettings& settings)
      : settings_(settings),
        is_one_tick_(settings.velocity.window_ticks <= 1),
        estimator_(settings.velocity) {}

  // d(p - g)/dt as the settings estimate it: by default the backward difference of one tick, with
  // which the damper takes B |du|^2 / T in each tick, never less than nothing. A longer window is
  // less noisy, and gives back some of that. Effects with a velocity of their own (viscosity) keep
  // the difference of one tick, so that what they take stays exact. Zero on the first tick of a
  // contact, which has no difference to take. lag_m: proxy minus goal.
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

  // See coupling_force_N().
  Vec3 force_N(const Vec3& lag_m, const Vec3& damped_m_per_s, const Vec3& normal) const noexcept {
    return coupling_force_N(settings_, lag_m, damped_m_per_s, normal);
  }

  // No contact in this tick, or none that a difference could be taken from.
  void reset() noexcept {
    had_contact_ = false;
    estimator_.reset();
  }

 private:
  CouplingSettings settings_;
  bool is_one_tick_;
  bool had_contact_ = false;
  Vec3 last_lag_m_ = Vec3::Zero();
  VelocityEstimator estimator_;  // of more ticks than one
};

}  // namespace palpate
