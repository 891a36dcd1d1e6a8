#pragma once

// The mass, the damping and the delay with which stability and energy of a device are computed: its
// own where they are known, otherwise those of its class. And the largest damping that a servo can
// add to such a device.

#include <algorithm>

#include "palpate/device.h"

namespace palpate {

// Values that no device of a class falls short of: the least mass and damping, and the longest
// delay at a rate of 1 kHz.
struct DeviceClass {
  const char* name;
  double mass_kg;
  double damping_Ns_per_m;
  DelayInterval delay;
};

// A tip that nobody holds, on a light pantograph or arm. The delay is the longest that was measured
// at a simulated hAPI board whose line takes 2 ms; a driver that measures its own states that.
inline constexpr DeviceClass kBareTip{"bare tip", 0.1, 0.5, {0.0, 3.1e-3}};

struct AssumedMechanics {
  double mass_kg = 0.0;           // > 0
  double damping_Ns_per_m = 0.0;  // > 0
  DelayInterval delay;
  // What the device does not state, and its class does.
  bool assumes_mass = false;
  bool assumes_damping = false;
  bool assumes_delay = false;

  constexpr bool assumes_any() const { return assumes_mass || assumes_damping || assumes_delay; }
};

// For a device that moves motors. Other devices exert no force on a hand: their unknown delay
// counts as none wherever a wall on them is judged (wall_delay_s() in
// engine/devices/stiffness_zones.h).
constexpr AssumedMechanics assumed_mechanics(const DeviceDescription& device,
                                             const DeviceClass& type = kBareTip) {
  AssumedMechanics mechanics{device.mass_kg, device.damping_Ns_per_m, device.delay};
  mechanics.assumes_mass = !(device.mass_kg > 0.0);
  mechanics.assumes_damping = !(device.damping_Ns_per_m > 0.0);
  mechanics.assumes_delay = !device.delay.is_known();
  if (mechanics.assumes_mass) mechanics.mass_kg = type.mass_kg;
  if (mechanics.assumes_damping) mechanics.damping_Ns_per_m = type.damping_Ns_per_m;
  if (mechanics.assumes_delay) mechanics.delay = type.delay;
  return mechanics;
}

// The controller of passivity computes its velocity from the positions of this time, at least of
// one tick. A longer window has less noise of the encoder, but adds half its length to the age of
// the velocity.
inline constexpr double kControllerVelocity_s = 2e-3;
inline constexpr int kMostControllerTicks = 64;  // no servo is faster than 32 kHz

// The number of ticks in that window: 2 at 1 kHz, 1 at 500 Hz and below. period_s > 0.
constexpr int controller_velocity_ticks(double period_s) {
  const double ticks = kControllerVelocity_s / period_s + 0.5;  // to the nearest
  if (!(ticks < kMostControllerTicks)) return kMostControllerTicks;
  return std::max(1, static_cast<int>(ticks));
}

// The age at which a damper's velocity still acts: the delay, the period for which the force is
// held, and half the window of the velocity.
constexpr double damper_age_s(double delay_s, double period_s, int velocity_ticks) {
  return delay_s + period_s + 0.5 * velocity_ticks * period_s;
}

// The largest damping that a servo may add: m / (2 t), t the age above. A damper B on a mass m that
// acts a time t late swings by itself from B = pi m / (2 t) on; this is less than a third of that.
// mass_kg > 0; period_s > 0.
constexpr double largest_damping_Ns_per_m(double mass_kg, double delay_s, double period_s,
                                          int velocity_ticks) {
  return mass_kg / (2.0 * damper_age_s(delay_s, period_s, velocity_ticks));
}

}  // namespace palpate
