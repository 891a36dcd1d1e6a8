#pragma once

// Runs a comparison of strategies.

#include <functional>
#include <optional>
#include <string>

#include "engine/session/stop_flag.h"
#include "engine/trials/compare/compare_plan.h"
#include "engine/trials/deal/experiment_run.h"
#include "geometry/base/result.h"

namespace palpate {

// The folder of the trials and the file of the plan, in the folder of a comparison.
std::string compare_trials_folder(const std::string& folder);
std::string compare_plan_path(const std::string& folder);

struct CompareOutcome {
  ExperimentRunOutcome run;
  OutputLock lock;  // of the folder: the caller may write the report there
};

// Runs the plan as run_experiment() does, and writes it. run: out_folder is the folder of the
// comparison. Trials that exist there from an earlier run of the same plan are kept; so shards in
// one folder, followed by a call without a shard, give the same bytes as one call.
Result<CompareOutcome> run_comparison(const CompareSettings& settings,
                                      const ExperimentRunSettings& run,
                                      const TrialFunctions& functions,
                                      const std::function<void(const RunProgress&)>& progress = {},
                                      const StopFlag* stop = nullptr);

}  // namespace palpate
