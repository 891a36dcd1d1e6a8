#pragma once

// How stiff a wall can be at the timing that a thread has reached.

#include <cstdint>

#include "engine/devices/stability_limits.h"
#include "engine/session/run_setup.h"
#include "engine/session/tick_times.h"
#include "geometry/base/result.h"

namespace palpate {

// The timing that 99.9 % of the ticks have reached.
struct ReachedTiming {
  std::int64_t period_ns = 0;  // from start to start
  std::int64_t delay_ns = 0;   // from reading the device to its command
  // From a sample to its force, with which the limits are computed: the device's longest
  // (wall_delay_s() in stiffness_zones.h), or delay_ns if that is longer. The two are not added,
  // because the delay of a device includes that of the host.
  double to_force_s = 0.0;
  StabilityLimits limits;  // of a wall with the damping of the setup; nobody holds the device
};

// times: of at least two ticks. The device has the numbers of wall_mechanics(). Returns the errors
// of stability_limits(). Thread-safe.
Result<ReachedTiming> reached_timing(const RunSetup& setup, const TickTimes& times);

}  // namespace palpate
