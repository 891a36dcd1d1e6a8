#pragma once

// The spring and damper in parallel between proxy and device point.

#include <algorithm>

#include "geometry/types.h"

namespace palpate {

struct CouplingSettings {
  double stiffness_N_per_m = 1000.0;  // K >= 0
  double damping_Ns_per_m = 2.0;      // B >= 0
};

// F = K (p - g) + B d(p - g)/dt in the scene frame, acting on the hand; backward difference. No
// damping on the first tick of a contact, which has no difference to take. Never attractive: a part
// that pulls along the contact normal is left out, so F.N >= 0.
// (Lecuyer et al. 2005, section 3: "a spring and a damper in parallel".)
// One instance belongs to one haptic loop. Safe on the haptic thread.
class VirtualCoupling {
 public:
  explicit VirtualCoupling(const CouplingSettings& settings) : settings_(settings) {}

  // lag_m: proxy minus goal. normal: unit contact normal, or zero where several cancel.
  Vec3 force_N(const Vec3& lag_m, const Vec3& normal, double dt_s) noexcept {
    Vec3 force = settings_.stiffness_N_per_m * lag_m;
    if (had_contact_) force += settings_.damping_Ns_per_m * (lag_m - last_lag_m_) / dt_s;
    had_contact_ = true;
    last_lag_m_ = lag_m;
    force += std::max(0.0, -force.dot(normal)) * normal;
    return force;
  }

  // No contact in this tick, or none that a difference could be taken from.
  void reset() noexcept { had_contact_ = false; }

 private:
  CouplingSettings settings_;
  bool had_contact_ = false;
  Vec3 last_lag_m_ = Vec3::Zero();
};

}  // namespace palpate
