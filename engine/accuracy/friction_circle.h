#pragma once

// A device goes round a circle at constant depth in a plane with friction, and the proxy follows on
// a smaller one.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct FrictionCircle {
  double friction = 0.5;  // static and dynamic
  double depth_m = 2e-3;
  double radius_m = 5e-3;  // of the device's circle; above lag_m()
  double turns_per_s = 2.0;
  CouplingSettings coupling = {};

  // L: how far the proxy stays behind, once it slides.
  double lag_m() const { return friction * depth_m; }
  // Always behind by L, in the direction that it moves: sqrt(rho^2 - L^2).
  double continuous_radius_m() const;
  // In steps of this length: the positive r with r^2 + 2 L r sin(a / 2) = rho^2 - L^2, where a is
  // the angle of a step. (The device is L beyond the new place of the proxy, on the line through
  // the old one.)
  double discrete_radius_m(double step_s) const;
};

// Half a turn to settle, after which exp(-pi r / L) is left of what it began with, and half a turn
// measured, in a random pose. error: of the radius of the proxy's circle, on average, m; time:
// computing for a second of contact, us.
Sample go_round(const FrictionCircle& circle, double step_s, const Accuracy& accuracy,
                std::uint64_t seed);

}  // namespace palpate
