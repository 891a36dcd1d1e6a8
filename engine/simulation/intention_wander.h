#pragma once

// The slow wandering of the position that a hand intends.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/simulation/standard_normal.h"
#include "geometry/base/types.h"

namespace palpate {

// A stationary Gaussian noise of second order along each axis, of variance 1:
//   eta'' = -2 z w eta' - w^2 eta + sqrt(4 z w^3) xi,   w = 2 pi f, z = 0.7, xi white noise.
// Its velocity has the standard deviation w. The noise therefore crosses the level -a downwards at
// the rate f exp(-a^2 / 2) (Rice 1945). A noise of first order has no finite rate of crossings.
//
// The steps are exact for every dt: the state is multiplied by the matrix exponential, and the
// covariance of the added noise keeps the state stationary. One thread owns an object; safe on the
// haptic thread.
class IntentionWander {
 public:
  // The noise after the next dt_s; in the first call, a draw from the stationary distribution. All
  // calls pass the same natural frequency and time step. No unit.
  Vec3 advance(double natural_Hz, double dt_s, std::mt19937_64& random) {
    if (!is_started_) start(natural_Hz, dt_s, random);
    for (int k = 0; k < 3; ++k) {
      const double a = standard_normal(random);
      const double b = standard_normal(random);
      const double x = position_[k];
      const double v = velocity_[k];
      position_[k] = phi_[0] * x + phi_[1] * v + chol_[0] * a;
      velocity_[k] = phi_[2] * x + phi_[3] * v + chol_[1] * a + chol_[2] * b;
    }
    return position_;
  }

 private:
  static constexpr double kDampingRatio = 0.7;

  // With positions divided by the standard deviation s and velocities by w s, the stationary
  // covariance is the identity, and the added noise has the covariance I - Phi Phi^T.
  void start(double natural_Hz, double dt_s, std::mt19937_64& random) {
    is_started_ = true;
    const double wt = 2.0 * std::numbers::pi * natural_Hz * dt_s;
    const double root = std::sqrt(1.0 - kDampingRatio * kDampingRatio);
    const double decay = std::exp(-kDampingRatio * wt);
    const double c = decay * std::cos(root * wt);
    const double s = decay * std::sin(root * wt) / root;
    phi_ = {c + kDampingRatio * s, s, -s, c - kDampingRatio * s};
    const double xx = 1.0 - phi_[0] * phi_[0] - phi_[1] * phi_[1];
    const double xv = -phi_[0] * phi_[2] - phi_[1] * phi_[3];
    const double vv = 1.0 - phi_[2] * phi_[2] - phi_[3] * phi_[3];
    chol_[0] = std::sqrt(std::max(0.0, xx));
    chol_[1] = chol_[0] > 0.0 ? xv / chol_[0] : 0.0;
    chol_[2] = std::sqrt(std::max(0.0, vv - chol_[1] * chol_[1]));
    for (int k = 0; k < 3; ++k) {
      position_[k] = standard_normal(random);
      velocity_[k] = standard_normal(random);
    }
  }

  bool is_started_ = false;
  std::array<double, 4> phi_{};   // the transition matrix, row by row
  std::array<double, 3> chol_{};  // the Cholesky factor of the added noise: xx, vx, vv
  Vec3 position_ = Vec3::Zero();  // in standard deviations
  Vec3 velocity_ = Vec3::Zero();  // in standard deviations times w
};

}  // namespace palpate
