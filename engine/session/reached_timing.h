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
  StabilityLimits limits;      // of a wall with the damping of the setup; nobody holds the device
};

// times: of at least two ticks. A delay D acts like periods that are longer by 2 D: in the first
// order of the period T, both limits depend on T / 2 + D (stability_limits.h). Returns the errors
// of stability_limits(). Thread-safe.
Result<ReachedTiming> reached_timing(const RunSetup& setup, const TickTimes& times);

}  // namespace palpate
