#pragma once

// All numbers of a sweep, for other programs. All follow from the rows of sweep.csv.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "engine/experiment/result_table.h"
#include "engine/experiment/sweep_analysis.h"

namespace palpate {

// The names of the tables, which are those of the CSV files, in the order of sweep_tables().
inline constexpr std::array<std::string_view, 4> kSweepTableNames = {"one_at_a_time", "flips",
                                                                     "rankings", "halves"};

// The means at the levels of each parameter; the flips; the shares of the hypercube at which
// rankings hold; and these shares in the halves, or at the words, of each parameter.
std::vector<ResultTable> sweep_tables(const SweepAnalysis& analysis);

// The tables as one JSON document, which begins with the name of the sweep.
std::string sweep_json(const SweepAnalysis& analysis, const std::string& name);

}  // namespace palpate
