#pragma once

// Runs a comparison of strategies: the trials of the hands that are compared, and of those that
// tune.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/session/stop_flag.h"
#include "engine/trials/compare/compare_plan.h"
#include "engine/trials/deal/experiment_run.h"
#include "geometry/base/result.h"

namespace palpate {

// The folders of the trials and the files of their plans, in the folder of a comparison.
std::string compare_trials_folder(const std::string& folder, CompareHands hands);
std::string compare_plan_path(const std::string& folder, CompareHands hands);

struct CompareOutcome {
  // The runs: of the compared hands and, if a strategy is tuned, of the tuning hands.
  std::vector<ExperimentRunOutcome> runs;
  OutputLock lock;  // of the folder: the caller may write the report there
};

// Runs the plans as run_experiment() does, and writes them. run: out_folder is the folder of the
// comparison. Trials that exist there from an earlier run of the same plan are kept; so shards in
// one folder, followed by a call without a shard, give the same bytes as one call.
Result<CompareOutcome> run_comparison(const CompareSettings& settings,
                                      const ExperimentRunSettings& run,
                                      const TrialFunctions& functions,
                                      const std::function<void(const RunProgress&)>& progress = {},
                                      const StopFlag* stop = nullptr);

}  // namespace palpate
