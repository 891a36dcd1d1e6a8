#pragma once

// A device moves on a circle at constant depth in a plane with friction, and the proxy follows on a
// smaller circle.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct FrictionCircle {
  double friction = 0.5;  // static and dynamic coefficient
  double depth_m = 2e-3;
  double radius_m = 5e-3;  // of the device's circle; larger than lag_m()
  double turns_per_s = 2.0;
  CouplingSettings coupling = {};

  // L: the tangential lag of a sliding proxy.
  double lag_m() const { return friction * depth_m; }
  // The radius of the proxy's circle in continuous time, where the lag L is along the direction of
  // motion: sqrt(rho^2 - L^2). rho: radius_m.
  double continuous_radius_m() const;
  // The radius of the proxy's circle with steps of this length: the positive solution r of
  //   r^2 + 2 L r sin(a / 2) = rho^2 - L^2,
  // where a is the angle of a step. (The device is at the distance L beyond the new position of the
  // proxy, on the line through the old and the new position.)
  double discrete_radius_m(double step_s) const;
};

// Moves the device, in a random pose, by half a turn to let the proxy settle, and then by another
// half turn, which is measured. After the first half turn, exp(-pi r / L) of the initial deviation
// is left. Sample::error: the error of the mean radius of the proxy's circle, m. Sample::time:
// computing time for one second of contact, us.
Sample go_round(const FrictionCircle& circle, double step_s, const Accuracy& accuracy,
                std::uint64_t seed);

}  // namespace palpate
