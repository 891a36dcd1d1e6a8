#pragma once

// Joins the parts of all participants into the results of a canonical run.

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

struct MergedCanonical {
  int participants = 0;
  std::uint64_t trials = 0;
  std::uint64_t without_result = 0;   // trials with no measure at all
  std::vector<std::string> warnings;  // figures that could not be drawn
};

// Reads the parts in these folders, checks them, and writes canonical.csv, columns.csv,
// canonical.html and run.json into out_folder, together or not at all. The rows are in the order of
// participants and, for each participant, in the order of CanonicalPlan::cells(). out_folder may be
// one of these folders. Results of other kinds of runs in it are removed.
//
// Errors, which name the file: those of join_parts(), and a result that cannot be written.
Result<MergedCanonical> merge_canonical(const std::vector<std::string>& folders,
                                        const std::string& out_folder);

}  // namespace palpate
