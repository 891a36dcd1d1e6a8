#pragma once

// A free mass bounces off a virtual wall and leaves faster than it arrived. The reason is that the
// force is held between two readings of the position; it is therefore too weak on the way into the
// wall and too strong on the way out.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/accuracy/tick_periods.h"
#include "engine/devices/light_device.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct BounceSetup {
  double mass_kg = light_device().mass_kg;
  double stiffness_N_per_m = 1000.0;
  double least_speed_m_per_s = 0.2;  // speed at which the mass arrives
  double most_speed_m_per_s = 0.3;

  double angular_frequency() const;  // sqrt(K / m), rad/s
  double contact_s() const;          // duration of a bounce: half a period
  // The energy gained through the held force, divided by the energy on arrival: (pi / 2) w T, to
  // first order in w T. w: angular_frequency(); T: period_s.
  double gain_to_first_order(double period_s) const;
};

// Simulates bounces at evenly spaced phases of the servo, in a random pose. Sample::error: the mean
// energy gained, divided by the kinetic energy on arrival. Sample::time: computing time for one
// second of contact, us.
Sample bounces(const BounceSetup& setup, const TickPeriods& periods, const Accuracy& accuracy,
               std::uint64_t seed);

}  // namespace palpate
