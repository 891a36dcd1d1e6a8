#pragma once

// All numbers of a sweep, for other programs. All follow from the rows of sweep.csv.

#include <string>
#include <vector>

#include "engine/analysis/result_table.h"
#include "engine/analysis/sweep_analysis.h"
#include "engine/trials/deal/result_names.h"

namespace palpate {

// The tables of kSweepTableNames, in this order.
//
// The means at the levels of each parameter; the flips; the shares of the hypercube at which
// rankings hold; and these shares in the halves, or at the words, of each parameter.
std::vector<ResultTable> sweep_tables(const SweepAnalysis& analysis);

// The tables as one JSON document, which begins with the name of the sweep.
std::string sweep_json(const SweepAnalysis& analysis, const std::string& name);

}  // namespace palpate
