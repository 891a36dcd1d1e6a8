#pragma once

// Results of runs that have a page: the page beside the measured files, all in place together, and
// what the user reads.

#include <functional>
#include <string>
#include <vector>

#include "engine/trials/canonical/canonical_merge.h"
#include "engine/trials/deal/dealt_run.h"
#include "engine/trials/sweep/sweep_merge.h"

namespace palpate {

struct PlacedResults {
  bool is_interrupted = false;        // nothing is in place
  std::string text;                   // for the user
  std::vector<std::string> warnings;  // one states that the page is missing, if it is
};

// Adds the page, and moves the measured files and the page into the folder (place_with_page).
Result<PlacedResults> place_results(MergedSweep merged, const std::string& folder);
Result<PlacedResults> place_results(MergedCanonical merged, const std::string& folder);

// What remains when a run has ended: says that it was interrupted, or that its shard is complete,
// or else places its results. kept: what was complete before, as the user reads it. noun: of a
// unit. merged_dir: the folder of a merge of shards that is shown. Returns the exit code.
int finish_dealt_run(const DealtOutcome& outcome, const DealtSettings& settings,
                     const std::string& kept, const std::string& noun,
                     const std::string& merged_dir,
                     const std::function<Result<PlacedResults>()>& place);

}  // namespace palpate
