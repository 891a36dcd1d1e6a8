#pragma once

// Joins the parts of all points into the results of a sweep.

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

struct MergedSweep {
  int points = 0;
  std::uint64_t trials = 0, done = 0, timeouts = 0, faults = 0;
  std::string text;                   // for a terminal: what the sweep found
  std::vector<std::string> warnings;  // a figure is missing; no trial was done
};

// Reads the parts in these folders, checks them (join_parts), and writes sweep.csv, the report
// (sweep_report.h) and run.json into out_folder, together or not at all. Results of
// another kind of run in out_folder are removed.
Result<MergedSweep> merge_sweep(const std::vector<std::string>& folders,
                                const std::string& out_folder);

}  // namespace palpate
