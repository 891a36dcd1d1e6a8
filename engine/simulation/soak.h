#pragma once

// A long run of the haptic thread with a simulated hand, to find late ticks and memory that grows.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/realtime.h"
#include "engine/session/run_setup.h"
#include "engine/session/run_summary.h"
#include "engine/session/stop_flag.h"
#include "engine/session/tick_times.h"
#include "geometry/base/result.h"

namespace palpate {

struct SoakSettings {
  double seconds = 60.0;
  std::uint64_t seed = 1;
  std::optional<int> cpu;        // see HapticThreadSettings
  bool keeps_cpu_times = false;  // of the first kMostKeptTimes ticks, 4 bytes each
};

// Memory of the process, bytes.
struct ProcessMemory {
  std::int64_t heap = 0;      // in use, as malloc counts it
  std::int64_t resident = 0;  // in physical memory

  static ProcessMemory now();
};

inline constexpr std::size_t kMostKeptTimes = std::size_t{1} << 26;

struct SoakRun {
  bool interrupted = false;                  // by a StopFlag
  std::optional<std::size_t> starts_inside;  // the object that encloses the hand at the start
  RealtimeStatus realtime;
  TickTimes tick_times;
  RunSummary summary;                  // without step_ns
  std::vector<std::uint32_t> cpu_ns;   // CPU time of each tick, if they are kept
  std::uint64_t ticks_not_finite = 0;  // ticks with a number in their record that is not finite
  // One second after the start, or at the end of a shorter run, and at the end.
  ProcessMemory memory_at_start, memory_at_end;
};

// Runs one session on the haptic thread. The hand follows a path (plan_hand) of as many laps as fit
// the time. Records of ticks are not kept, so that the memory does not depend on the time.
//
// Errors: as explore(); the number of ticks has no limit.
Result<SoakRun> soak(const Scene& scene, const RunSetup& setup, const SoakSettings& settings,
                     const std::function<void(double)>& progress, const StopFlag* stop = nullptr);

}  // namespace palpate
