#pragma once

// The report of a comparison of strategies: one page for readers, and tables for programs.

#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/strategy_comparison.h"
#include "engine/report/output_files.h"
#include "engine/trials/compare/compare_plan.h"
#include "geometry/base/result.h"

namespace palpate {

// An HTML5 document (UTF-8) that needs no other file, no network and no script. It begins with the
// best technique by each measure and with the measures in which A4 loses; then follow all means and
// paired differences, the tuning, each scene, and how to read them.
std::string comparison_html(const CompareSettings& settings,
                            const std::vector<FollowingComparison>& followings);

// The names of the files that write_comparison_report() writes.
std::vector<std::string> comparison_report_names();

// Writes report.html, comparison.json and a CSV file for each of kStrategyTableNames. files:
// created with the names of comparison_report_names().
std::optional<Error> write_comparison_report(const CompareSettings& settings,
                                             const std::vector<FollowingComparison>& followings,
                                             const OutputFiles& files);

}  // namespace palpate
