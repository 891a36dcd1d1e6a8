#pragma once

// How stiff a wall may be on a device whose motors move: stable by itself, calm by the controller
// of passivity, or more than that controller can hold.

#include <cstdint>

#include "engine/devices/stability_limits.h"
#include "geometry/base/result.h"
#include "haptics/device_mechanics.h"
#include "haptics/effects/velocity_estimator.h"
#include "palpate/device.h"

namespace palpate {

enum class StiffnessZone : std::uint8_t {
  kStable,      // the loop comes to rest by itself
  kControlled,  // it comes to rest only by the controller's damper
  kRefused      // no damping that the delay permits brings it to rest
};

// "stable", "calm only by the controller" or "refused".
const char* name_of(StiffnessZone zone);

// The stiffness that --stiffness auto takes, as a part of the stable limit: a gain margin of two.
// It covers what the model leaves out: a delay that changes from tick to tick, and a mass that
// depends on the direction.
inline constexpr double kAutoPart = 0.5;

// The stiffness that the controller may hold, as a part of the limit with its largest damping: a
// gain margin of two. A loop at its limit swings for ever. At half the limit, the slowest motion of
// a bare tip decays at least as fast as that of the tip on a spring without delay, e^(-b t / 2 m).
// Computed for 0.05 to 1 kg and 0.5 N s/m at 250 Hz to 10 kHz and delays of 0 to 5 ms, it
// decays 3.8 to 430 times as fast; at 0.8 of the limit 1.3 times, at 0.9 in some cases more slowly.
// `stiffness_zones_test` computes these again.
inline constexpr double kCalmPart = 0.5;

// N/m, for the mechanics at the worst end of the delay, a tip that nobody holds, and the damping of
// the coupling.
struct StiffnessZones {
  AssumedMechanics mechanics;
  double period_s = 0.0;
  double passive_N_per_m = 0.0;   // 0: no wall with this damping is passive
  double stable_N_per_m = 0.0;    // 0: no wall with this damping is stable
  double calm_N_per_m = 0.0;      // kCalmPart of the limit with the controller, or stable_N_per_m
  double auto_N_per_m = 0.0;      // kAutoPart of stable_N_per_m
  double damping_Ns_per_m = 0.0;  // the controller's largest, with the window below
  int velocity_ticks = 1;

  StiffnessZone zone_of(double stiffness_N_per_m) const {
    if (stiffness_N_per_m < stable_N_per_m) return StiffnessZone::kStable;
    return stiffness_N_per_m <= calm_N_per_m ? StiffnessZone::kControlled : StiffnessZone::kRefused;
  }
};

// The zones of a device with the mechanics that it states or its class has. A device that samples
// more rarely than the loop ticks has a longer delay by as much. What the coupling's
// damping leaves of the largest damping is the controller's. velocity: of the coupling's damper; a
// longer window makes its velocity older and the zones smaller. With the adaptive method the zones
// are those of the worst window; changes from one window to another are not computed, and are left
// to the margins. Returns the errors of stability_limits(). Not for the haptic thread. Thread-safe.
Result<StiffnessZones> stiffness_zones(const DeviceDescription& device,
                                       double coupling_damping_Ns_per_m, double period_s,
                                       const VelocitySettings& velocity = {});

// What a wall on this device is judged with, wherever one is: the numbers that the device states,
// and the longest delay of the interval. What a device that moves motors does not state is that of
// its class (assumed_mechanics()). The unknown delay of any other device counts as 0, because no
// hand feels its force, and its other unknown numbers stay 0.
DeviceMechanics wall_mechanics(const DeviceDescription& device);
double wall_delay_s(const DeviceDescription& device);

}  // namespace palpate
