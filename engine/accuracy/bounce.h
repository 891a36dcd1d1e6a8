#pragma once

// A free mass bounces off a virtual wall, and leaves it faster than it came: between two readings
// the force is that of where it was, too weak on the way in and too strong on the way out.

#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/accuracy/tick_periods.h"
#include "engine/devices/light_device.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

struct BounceSetup {
  double mass_kg = light_device().mass_kg;
  double stiffness_N_per_m = 1000.0;
  double least_speed_m_per_s = 0.2;  // at which it comes
  double most_speed_m_per_s = 0.3;

  double angular_frequency() const;  // sqrt(K / m), rad/s
  double contact_s() const;          // half a period of it: how long a bounce takes
  // (pi / 2) w T: what the held force gains to first order in w T, over the energy that came.
  double gain_to_first_order(double period_s) const;
};

// Bounces at even phases of the servo, in a random pose. error: the energy gained over the kinetic
// energy that came, on average; time: computing for a second of contact, us.
Sample bounces(const BounceSetup& setup, const TickPeriods& periods, const Accuracy& accuracy,
               std::uint64_t seed);

}  // namespace palpate
