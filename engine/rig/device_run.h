#pragma once

// A person explores a scene with a device that has motors.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/session/run_summary.h"
#include "engine/session/start_inside.h"
#include "engine/session/stop_flag.h"
#include "engine/session/tick_sink.h"
#include "engine/session/tick_times.h"
#include "geometry/base/result.h"

namespace palpate {

struct DeviceRunSettings {
  double seconds = 28.0;
  std::optional<int> cpu;         // see HapticThreadSettings
  bool has_guard = true;          // see GuardedRunSettings
  bool without_realtime = false;  // see GuardedRunSettings
  bool takes_motors = true;       // see SessionParts
  // As in ExplorationSettings.
  std::uint64_t max_memory_bytes = 0;
  std::uint64_t taken_memory_bytes = 0;
  TickSink* sink = nullptr;  // records the session; null: nothing does
  // A hand that begins inside a closed surface stays there and feels it. Otherwise it gets no force
  // until it has left (StartInside).
  bool stays_inside = false;
  // Called on the owner's thread when StartInside::status() has changed; may be empty.
  std::function<void(const StartInside::Status&)> on_start_inside = {};
};

struct DeviceRun {
  bool interrupted = false;  // by a StopFlag; the records then end early and may be empty
  std::vector<TickRecord> records;
  RunSummary summary;
  std::uint64_t missed_deadlines = 0;
  TickTimes tick_times;
  GovernorStatus governor;  // after the last tick
  bool has_fifo = false;    // the haptic thread and the guard have SCHED_FIFO
  DeviceHealth health;      // at the end
  LineRate line;            // of the whole session
  StartInside::Status start_inside;
  std::vector<std::string> warnings;
};

// Runs one session (GuardedRun) until the time is over, until `stop` is requested, or until the
// governor trips; the force is zero from the trip on. progress: see explore(). stop: may be null.
//
// Errors: a setting is out of range or NaN, or check_setup() rejects it; a node in setup.moves does
// not exist; the run has more ticks than can be recorded or needs too much memory; a step of the
// start failed. No force was commanded then.
Result<DeviceRun> run_device(const Scene& scene, const RunSetup& setup, GuardableDevice& device,
                             const DeviceRunSettings& settings,
                             const std::function<void(double)>& progress,
                             const StopFlag* stop = nullptr);

}  // namespace palpate
