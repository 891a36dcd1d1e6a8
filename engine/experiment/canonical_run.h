#pragma once

// Runs the canonical protocol: all participants of a plan, or those of a shard.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/experiment/canonical_plan.h"
#include "engine/experiment/dealt_run.h"
#include "engine/session/stop_flag.h"
#include "geometry/base/result.h"

namespace palpate {

// The names of the results in the folder of a canonical run, besides kColumnsFile and kRunFile.
inline constexpr const char* kCanonicalFile = "canonical.csv";
inline constexpr const char* kCanonicalPage = "canonical.html";

struct MergedCanonical {
  int participants = 0;
  std::uint64_t trials = 0;
  std::uint64_t without_result = 0;   // trials with no measure at all
  std::vector<std::string> warnings;  // figures that could not be drawn
};

// Reads the parts in these folders, checks them, and writes canonical.csv, columns.csv,
// canonical.html and run.json into out_folder, together or not at all. The rows are in the order of
// participants and, for each participant, in the order of CanonicalPlan::cells(). out_folder may be
// one of these folders. Results of an experiment in it are removed: trials.csv, if the run.json
// beside it is of an experiment.
//
// Errors, which name the file: those of join_parts(), and a result that cannot be written.
Result<MergedCanonical> merge_canonical(const std::vector<std::string>& folders,
                                        const std::string& out_folder);

// kCanonicalFile and kCanonicalPage if the folder has the former: the results that an experiment in
// the same folder replaces.
std::vector<std::string> canonical_results_in(const std::string& folder);

// The results of an experiment in a folder, besides kColumnsFile and kRunFile; empty if there are
// none. A trials.csv without the run.json of an experiment was not written by this program.
std::vector<std::string> experiment_results_in(const std::string& folder);

struct CanonicalRunOutcome : DealtOutcome {
  std::optional<MergedCanonical> merged;  // no value: a shard, or stopped
};

// run_dealt() with participants as units. The bytes of all results depend only on the plan and its
// operator file, and not on shards, jobs or the number of starts. Without a shard,
// merge_canonical() follows when all parts exist.
//
// The noise of the hand has the seed KeyHash("canonical noise", seed of the plan, participant,
// angle_deg, motion, rotation).
//
// Errors: those of run_dealt(), run_canonical_trial() and merge_canonical(). An error of the
// setting of a device names the key of the plan, and occurs before anything is written.
Result<CanonicalRunOutcome> run_canonical(
    const CanonicalPlan& plan, const DealtSettings& settings,
    const std::function<void(const RunProgress&)>& progress = {}, const StopFlag* stop = nullptr);

}  // namespace palpate
