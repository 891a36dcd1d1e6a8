#pragma once

// The main use case: a simulated hand explores a scene.

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/rig/record_keeper.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/session/stop_flag.h"
#include "engine/session/tick_sink.h"
#include "engine/session/tick_times.h"
#include "geometry/base/result.h"

namespace palpate {

struct ExplorationSettings {
  double seconds = 28.0;      // 1 s for the approach, the rest for following the path
  bool virtual_time = false;  // ticks run as fast as possible, without the real-time thread
  std::uint64_t seed = 1;
  // Limit on the memory of the run. It includes taken_memory_bytes, the memory that the caller
  // already uses. 0: half of the free memory (memory_budget.h).
  std::uint64_t max_memory_bytes = 0;
  std::uint64_t taken_memory_bytes = 0;
  TickSink* sink = nullptr;  // records the session; null: nothing does
};

struct ExplorationRun {
  bool a4 = false;
  bool interrupted = false;  // by a StopFlag; the records then end early and may be empty
  std::vector<TickRecord> records;
  RunSummary summary;
  // The planned path, from its start point; exactly one of these two lists is empty. With 2
  // sensors: the contour; a closed contour ends at its start point. With 3 sensors: the places,
  // points at equal distances along the whole path, reached or not. Scene frame.
  std::vector<Vec3> contour_scene_m;
  std::vector<Vec3> places_scene_m;
  // Coverage: the share of the contour's length, or of the places, that the proxy approached to
  // within near_m.
  double way_share = 0.0;
  bool is_open_contour = false;  // PlannedHand
  double late_way_share = 0.0;   // the part of way_share covered in the last fifth of the run
  double near_m = 0.0;
  double proxy_radius_m = 0.0;
  std::optional<std::uint64_t> missed_deadlines;  // no value in simulated time
  std::optional<TickTimes> tick_times;            // no value in simulated time
  bool exceeds_workspace = false;
  std::string realtime_note;  // which real-time privileges the system denied

  std::uint64_t record_bytes() const { return records.size() * kBytesPerTick; }
};

// The distance within which the proxy covers the path: the larger of kNearWay_m and kNearWayShare
// times the largest extent of the scene, plus the sphere's radius, because the proxy is the
// sphere's centre.
inline constexpr double kNearWay_m = 2e-3;
inline constexpr double kNearWayShare = 0.01;

// Checks the settings as explore() does. The error names the invalid field.
std::optional<Error> check_exploration(const ExplorationSettings& settings, double dt_s);

// A function that is called from time to time, on the thread that called explore(), with the
// completed share of the run, 0 to 1.
using Progress = std::function<void(double)>;

// Runs one exploration. With 2 sensors the hand follows the longest outline of the section at the
// plane height; with 3 sensors it follows a path over the surface. stop: once it is requested, the
// run ends after the current tick or a few ticks later; may be null. At the end of every run, zero
// force is commanded.
//
// Errors: the scene has no section at the plane height; a setting is out of range or NaN, or
// check_setup() rejects it; the run has more ticks than can be recorded; the run needs more memory
// than the settings allow or the system has.
Result<ExplorationRun> explore(const Scene& scene, const RunSetup& setup,
                               const ExplorationSettings& settings, const Progress& progress,
                               const StopFlag* stop = nullptr);

}  // namespace palpate
