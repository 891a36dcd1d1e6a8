#pragma once

// Joins the parts of all participants into the results of an experiment.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

struct MergedExperiment {
  int participants = 0;
  std::uint64_t trials = 0;
  std::array<std::uint64_t, kTrialStatusNames.size()> by_status{};  // in the order of TrialStatus
};

// Reads the parts in these folders, checks them, and writes trials.csv, columns.csv and run.json
// into out_folder, together or not at all. The rows are in the order of participants and, for each
// participant, in the order in which the trials ran. out_folder may be one of these folders.
//
// Errors, which name the file: those of join_parts(), and a result that cannot be written.
Result<MergedExperiment> merge_experiment(const std::vector<std::string>& folders,
                                          const std::string& out_folder);

}  // namespace palpate
