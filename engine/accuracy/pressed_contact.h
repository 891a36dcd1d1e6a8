#pragma once

// A hand presses a device against a virtual wall with a steady force, then with twice this force.
// The path in continuous time is known in closed form; the path with a servo is compared with it.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/devices/light_device.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct PressedContact {
  double mass_kg = light_device().mass_kg;
  double damping_Ns_per_m = light_device().damping_Ns_per_m;  // damping of the device
  CouplingSettings coupling = {1000.0, 1.0};
  // The force of the hand from time 0 on. Before time 0, the hand pushes with half of this force,
  // and the device is at rest.
  double push_N = 2.0;
  double duration_s = 0.5;  // about four time constants: the motion has nearly settled

  // The default contact, but with the mass and the damping of this device. Its duration is the same
  // number of time constants, but at least 0.5 s and at most 5 s.
  static PressedContact on(const DeviceDescription& device);

  double static_depth_m() const { return push_N / coupling.stiffness_N_per_m; }
  double start_depth_m() const { return 0.5 * static_depth_m(); }

  // The depth at a time >= 0 in continuous time: the solution of m x'' = -(b + B) x' - K x + f. It
  // is computed by the matrix exponential and is exact to within rounding.
  double depth_m(double time_s) const;
};

// Simulates the contact with a servo of this period, in a random pose; the hand begins to push
// harder at a random phase of the servo. Sample::error: the largest deviation from depth_m(),
// divided by the static depth. Sample::time: computing time for one second of contact, us. If the
// motion grows instead of decaying, the failure states the stability limit.
Sample press(const PressedContact& contact, double period_s, const Accuracy& accuracy,
             std::uint64_t seed);

}  // namespace palpate
