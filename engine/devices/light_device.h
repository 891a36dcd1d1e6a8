#pragma once

// The default device of the program.

#include <algorithm>
#include <cstddef>

#include "palpate/device.h"

namespace palpate {

// The smallest of the workspace's three extents, in m. Every extent is at least this long.
inline double workspace_extent_m(const DeviceDescription& device) {
  double least_m = device.workspace_high_m[0] - device.workspace_low_m[0];
  for (std::size_t k = 1; k < 3; ++k) {
    least_m = std::min(least_m, device.workspace_high_m[k] - device.workspace_low_m[k]);
  }
  return least_m;
}

// Whether a device travels farther along an axis than any workspace of this extent allows, wherever
// it is placed. device_travel_m: RunSummary::device_travel_m().
inline bool exceeds_workspace(double device_travel_m, double extent_m) {
  return device_travel_m > extent_m;
}

// Sets the workspace to a cube centred at the origin of the device frame. extent_m: its side, > 0.
inline void set_workspace_extent(DeviceDescription& device, double extent_m) {
  device.workspace_low_m.fill(-0.5 * extent_m);
  device.workspace_high_m.fill(0.5 * extent_m);
}

// A light desktop device: a pantograph or a small parallel arm, driven by cables, with optical
// encoders. It is simulated and moves no motors. The description contains no motors either, because
// the user chooses the actuated axes.
inline DeviceDescription light_device() {
  DeviceDescription device;
  device.name = "light desktop device";
  device.moves_motors = false;
  device.peak_force_N = 20.0;
  set_workspace_extent(device, 0.4);
  device.mass_kg = 0.1;
  device.damping_Ns_per_m = 0.5;
  device.coulomb_friction_N = 0.02;
  device.encoder_quantum_m = 20e-6;
  device.rate_Hz = 1000.0;
  device.when_host_is_silent = HostSilence::kHoldsForce;
  return device;
}

}  // namespace palpate
