#pragma once

// Joins the parts of all points into the results of a sweep.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/report/output_files.h"
#include "geometry/base/result.h"

namespace palpate {

struct SweepCounts {
  int points = 0;
  std::uint64_t trials = 0, done = 0, timeouts = 0, faults = 0;
};

struct MergedSweep : SweepCounts {
  OutputFiles files;  // the measured files, not in place; the page may be added (page_names)
};

// Reads the parts in these folders, checks them (join_parts), and writes sweep.csv, columns.csv and
// run.json for out_folder, which may be one of these folders (stage_results).
Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder);

}  // namespace palpate
