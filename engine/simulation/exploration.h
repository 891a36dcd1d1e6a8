#pragma once

// The main job: a simulated hand explores a scene.

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/session/run_summary.h"
#include "engine/session/stop_flag.h"
#include "geometry/base/result.h"

namespace palpate {

struct ExplorationSettings {
  double seconds = 28.0;      // the approach takes one of them, the turn the rest
  bool virtual_time = false;  // as fast as it goes, instead of the real-time thread
  std::uint64_t seed = 1;
  // Memory that the run may take, with what the caller has taken of it before; 0: half of what is
  // free (memory_budget.h).
  std::uint64_t max_memory_bytes = 0;
  std::uint64_t taken_memory_bytes = 0;
};

struct ExplorationRun {
  bool a4 = false;
  bool interrupted = false;  // by a StopFlag: the records end there, and may be none
  std::vector<TickRecord> records;
  RunSummary summary;
  // What the hand set out to follow, from where it began: a closed contour ends there. With 3
  // sensors places at equal distances along its whole path, reached or not. Scene frame; one of the
  // two is empty.
  std::vector<Vec3> contour_scene_m;
  std::vector<Vec3> places_scene_m;
  // The part of the contour's length, or of the places, that had the proxy within near_m.
  double way_share = 0.0;
  double late_way_share = 0.0;  // of it, what came in the last fifth of the run
  double near_m = 0.0;
  double proxy_radius_m = 0.0;
  std::uint64_t missed_deadlines = 0;
  bool exceeds_workspace = false;
  std::string realtime_note;  // what the system did not grant

  std::uint64_t record_bytes() const {
    return records.size() * (sizeof(TickRecord) + sizeof(std::int64_t));
  }
};

// How near to what it follows the proxy counts as there: this, or of the largest extent of the
// scene, whichever is larger; and a sphere's radius more, since its centre is the proxy.
inline constexpr double kNearWay_m = 2e-3;
inline constexpr double kNearWayShare = 0.01;

// Settings that explore() would refuse; the error names the field.
std::optional<Error> check_exploration(const ExplorationSettings& settings, double dt_s);

// Called now and then from the calling thread with the share of the run that is done.
using Progress = std::function<void(double)>;

// One run. With 2 sensors the hand follows the longest outline of what the plane height cuts; with
// 3 it follows a path over the surface. An error if there is nothing at the plane height, or if the
// settings are out of range (NaN included; also those that check_setup() refuses), make more ticks
// than are kept in memory, or need more of it than they allow or the system has. stop: ends the run
// after the present tick, or a few later; null for none. However a run ends, zero force is
// commanded.
Result<ExplorationRun> explore(const Scene& scene, const RunSetup& setup,
                               const ExplorationSettings& settings, const Progress& progress,
                               const StopFlag* stop = nullptr);

}  // namespace palpate
