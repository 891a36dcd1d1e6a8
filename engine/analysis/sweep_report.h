#pragma once

// The report of a sweep: one page for readers, tables for programs, and lines for the terminal.

#include <string>
#include <utility>
#include <vector>

#include "engine/analysis/sweep_analysis.h"
#include "engine/trials/deal/run_identity.h"

namespace palpate {

// Names and texts of report.html, sweep_results.json and a CSV file for each table of
// sweep_tables.h. Appends to `warnings` if figures could not be drawn.
std::vector<std::pair<std::string, std::string>> sweep_report(const SweepAnalysis& analysis,
                                                              const RunIdentity& identity,
                                                              std::vector<std::string>& warnings);

// A few lines for a terminal: the share of each ranking, and the parameter that decides most.
std::string sweep_text(const SweepAnalysis& analysis);

}  // namespace palpate
