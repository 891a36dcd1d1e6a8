#pragma once

// Joins the parts of all participants into the results of a canonical run.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/report/output_files.h"
#include "geometry/base/result.h"

namespace palpate {

struct MergedCanonical {
  int participants = 0;
  std::uint64_t trials = 0;
  std::uint64_t without_result = 0;  // trials with no measure at all
  OutputFiles files;  // the measured files, not in place; the page may be added (page_names)
};

// Reads the parts in these folders, checks them, and writes canonical.csv, columns.csv and run.json
// for out_folder, which may be one of these folders (stage_results). The rows are in the order of
// participants and, for each participant, in the order of CanonicalPlan::cells().
//
// Errors, which name the file: those of join_parts(), and a result that cannot be written.
Result<MergedCanonical> merge_canonical(const std::vector<std::string>& folders,
                                        const std::string& out_folder);

}  // namespace palpate
