#pragma once

// Runs a sweep: all points, or those of a shard.

#include <functional>
#include <string>
#include <vector>

#include "engine/session/stop_flag.h"
#include "engine/trials/deal/dealt_run.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/sweep/sweep_file.h"
#include "geometry/base/result.h"

namespace palpate {

// The units are points.
struct SweepOutcome : DealtOutcome {
  std::vector<std::string> scene_warnings;
};

// Runs the points of the shard as run_dealt() does, with run_participant() for each participant of
// a point. merge_sweep() makes the results when all parts exist. The bytes of all results depend
// only on the sweep and its files. Errors: a result would replace the file of the sweep; those of
// load_sweep_scenes(), run_participant() and run_dealt().
Result<SweepOutcome> run_sweep(const Sweep& sweep, const DealtSettings& settings,
                               const TrialFunctions& functions,
                               const std::function<void(const RunProgress&)>& progress = {},
                               const StopFlag* stop = nullptr);

}  // namespace palpate
