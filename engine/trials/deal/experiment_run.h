#pragma once

// Runs an experiment: all participants of a plan, or those of a shard.

#include <functional>
#include <optional>
#include <string>

#include "engine/session/stop_flag.h"
#include "engine/trials/deal/dealt_run.h"
#include "engine/trials/deal/experiment_merge.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "geometry/base/result.h"

namespace palpate {

struct ExperimentRunSettings {
  std::string out_folder;
  std::optional<Shard> shard;  // no value: all participants, and the results are merged
  int jobs = 1;                // threads; each runs one participant at a time
  bool writes_traces = false;  // out_folder/traces, one file per trial (trace_name)
};

// The units are participants.
struct ExperimentRunOutcome : DealtOutcome {
  std::optional<MergedExperiment> merged;  // no value: a shard, or stopped
  std::vector<std::string> scene_warnings;
};

// Runs the participants of the shard as run_dealt() does. The bytes of all results depend only on
// the plan and its files, and not on shards, jobs or the number of starts. Without a shard,
// merge_experiment() follows when all parts exist.
//
// progress, stop: as for run_dealt(). Errors: those of load_experiment_scenes(), check_persons(),
// run_participant(), run_dealt() and merge_experiment().
Result<ExperimentRunOutcome> run_experiment(
    const ExperimentPlan& plan, const ExperimentRunSettings& settings,
    const TrialFunctions& functions, const std::function<void(const RunProgress&)>& progress = {},
    const StopFlag* stop = nullptr);

}  // namespace palpate
