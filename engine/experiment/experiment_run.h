#pragma once

// Runs an experiment: all participants of a plan, or those of a shard.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/experiment/experiment_merge.h"
#include "engine/experiment/experiment_scene.h"
#include "engine/experiment/plan.h"
#include "engine/session/stop_flag.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr int kMostShards = 10'000;
inline constexpr int kMostJobs = 1024;

// Shard i of n has the participants i, i + n, i + 2 n and so on.
struct Shard {
  int number = 1;  // 1 to count
  int count = 1;
};
std::vector<int> participants_of(const Shard& shard, int participants);

struct ExperimentRunSettings {
  std::string out_folder;
  std::optional<Shard> shard;  // no value: all participants, and the results are merged
  int jobs = 1;                // threads; each runs one participant at a time
  bool writes_traces = false;  // out_folder/traces, one file per trial (trace_name)
};

// Passed to the caller while trials run.
struct ExperimentProgress {
  double share = 0.0;                 // of the trials to compute, 0 to 1
  std::optional<double> time_left_s;  // no value: unknown, before the first trial
};

struct ExperimentRunOutcome {
  std::vector<int> computed;               // participants, in ascending order
  std::vector<int> kept;                   // participants whose parts existed before
  std::vector<int> not_done;               // participants that a stop left out
  std::optional<MergedExperiment> merged;  // no value: a shard, or stopped
};

// Runs the participants for which the folder does not contain a part of this run yet. After the
// last trial of a participant, its part is written, whole or not at all. A killed run can therefore
// be started again. The bytes of all results depend only on the plan and its files, and not on
// shards, jobs or the number of starts. Parts of another plan in the folder are replaced. Without a
// shard, merge_experiment() follows when all parts exist. The file run.log in the folder records
// the times of day and the computing times.
//
// progress: called on the calling thread. stop: may be null; if it is set, running participants end
// after their present trial and leave no part. Errors: those of load_experiment_scenes(),
// check_persons(), run_participant() and merge_experiment(), and errors of writing. After an error,
// the parts of all completed participants are kept.
Result<ExperimentRunOutcome> run_experiment(
    const ExperimentPlan& plan, const ExperimentRunSettings& settings,
    const TrialFunctions& functions,
    const std::function<void(const ExperimentProgress&)>& progress = {},
    const StopFlag* stop = nullptr);

}  // namespace palpate
