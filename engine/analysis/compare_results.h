#pragma once

// What a comparison of strategies found, from the files of its trials.

#include <string>
#include <vector>

#include "engine/analysis/strategy_comparison.h"
#include "engine/trials/compare/compare_plan.h"
#include "geometry/base/result.h"

namespace palpate {

// Compares the strategies of a complete comparison (compare_run.h) whose trials are in this folder:
// one result for each following, in the order of the plan. Errors: those of compare_plan() and
// read_trials().
Result<std::vector<FollowingComparison>> compare_results(const CompareSettings& settings,
                                                         const std::string& folder);

}  // namespace palpate
