#pragma once

// Runs a sweep: all points, or those of a shard; and joins its parts.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/experiment/dealt_run.h"
#include "engine/experiment/experiment_scene.h"
#include "engine/experiment/sweep_file.h"
#include "engine/session/stop_flag.h"
#include "geometry/base/result.h"

namespace palpate {

// The file of the rows in the folder of a sweep (sweep_rows.h).
inline constexpr const char* kSweepFile = "sweep.csv";

struct MergedSweep {
  int points = 0;
  std::uint64_t trials = 0, done = 0, timeouts = 0, faults = 0;
  std::string text;                   // for a terminal: what the sweep found
  std::vector<std::string> warnings;  // a figure is missing; no trial was done
};

// The units are points.
struct SweepOutcome : DealtOutcome {
  std::optional<MergedSweep> merged;  // no value: a shard, or stopped
  std::vector<std::string> scene_warnings;
};

// Runs the points of the shard as run_dealt() does, with run_participant() for each participant of
// a point. Without a shard, merge_sweep() follows when all parts exist. The bytes of all results
// depend only on the sweep and its files. Errors: a result would replace the file of the sweep;
// those of load_sweep_scenes(), run_participant(), run_dealt() and merge_sweep().
Result<SweepOutcome> run_sweep(const Sweep& sweep, const DealtSettings& settings,
                               const TrialFunctions& functions,
                               const std::function<void(const RunProgress&)>& progress = {},
                               const StopFlag* stop = nullptr);

// The results of a sweep in a folder, besides kRunFile; empty if its run.json is not of a sweep.
std::vector<std::string> sweep_result_names_in(const std::string& folder);

// Reads the parts in these folders, checks them (join_parts), and writes sweep.csv, the report
// (sweep_report.h) and run.json into out_folder, together or not at all. Results of
// another kind of run in out_folder are removed.
Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder);

}  // namespace palpate
