#pragma once

// A model of a device: a mass on a viscous damper.

#include <cmath>

#include "geometry/base/types.h"

namespace palpate {

// For a force that is constant over a step, the motion is the exact solution of m x'' = -b x' + f
// for any step length. Device frame, SI. m > 0, b >= 0; without damping, the mass is free. Safe on
// the haptic thread. Only one thread may use an object.
class MassDamper {
 public:
  MassDamper(double mass_kg, double damping_Ns_per_m)
      : mass_kg_(mass_kg), damping_Ns_per_m_(damping_Ns_per_m) {}

  void put(const Vec3& at_m, const Vec3& velocity_m_per_s) {
    position_m_ = at_m;
    velocity_m_per_s_ = velocity_m_per_s;
  }

  // With a = b dt / m, g(a) = (1 - e^-a) / a and h(a) = (1 - g(a)) / a:
  // x += dt g v + dt^2 h f / m, then v = e^-a v + dt g f / m.
  void advance(const Vec3& force_N, double dt_s) {
    const double a = damping_Ns_per_m_ * dt_s / mass_kg_;
    const double g = a > 0.0 ? -std::expm1(-a) / a : 1.0;
    const Vec3 pushed_m_per_s = dt_s / mass_kg_ * force_N;
    position_m_ += dt_s * (g * velocity_m_per_s_ + lag(a) * pushed_m_per_s);
    velocity_m_per_s_ = std::exp(-a) * velocity_m_per_s_ + g * pushed_m_per_s;
  }

  const Vec3& position_m() const { return position_m_; }
  const Vec3& velocity_m_per_s() const { return velocity_m_per_s_; }
  double kinetic_J() const { return 0.5 * mass_kg_ * velocity_m_per_s_.squaredNorm(); }

 private:
  // h(a). For a <= 1 the closed form loses digits, and a series is used instead: the sum over k of
  // (-a)^k / (k + 2)!. Its remainder after 18 terms is below 2^-53 (1 / 20! = 4e-19).
  static double lag(double a) {
    if (a > 1.0) return (1.0 + std::expm1(-a) / a) / a;
    double sum = 0.0;
    for (int k = 17; k >= 0; --k) sum = (1.0 - a * sum) / (k + 2);
    return sum;
  }

  double mass_kg_;
  double damping_Ns_per_m_;
  Vec3 position_m_ = Vec3::Zero();
  Vec3 velocity_m_per_s_ = Vec3::Zero();
};

}  // namespace palpate
