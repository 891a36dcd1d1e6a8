#pragma once

// A device that a steady hand presses on a virtual wall, and then twice as hard: what continuous
// time would make of it, and what a servo does.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/devices/light_device.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct PressedContact {
  double mass_kg = light_device().mass_kg;
  double damping_Ns_per_m = light_device().damping_Ns_per_m;  // of the device
  CouplingSettings coupling = {1000.0, 1.0};
  double push_N = 2.0;      // of the hand from time 0 on; half as much before, at rest
  double duration_s = 0.5;  // four time constants of the coupling above: it has nearly settled

  double static_depth_m() const { return push_N / coupling.stiffness_N_per_m; }
  double start_depth_m() const { return 0.5 * static_depth_m(); }

  // How deep it is at a time >= 0 in continuous time: m x'' = -(b + B) x' - K x + f by the
  // exponential of the matrix. Exact to rounding.
  double depth_m(double time_s) const;
};

// A servo of this period does it, in a random pose, the hand pushing from a random phase on. error:
// the largest deviation from depth_m() over the static depth; time: computing for a second of
// contact, us. Where the motion grows instead of dying out, the failure says so, with the limit.
Sample press(const PressedContact& contact, double period_s, const Accuracy& accuracy,
             std::uint64_t seed);

}  // namespace palpate
