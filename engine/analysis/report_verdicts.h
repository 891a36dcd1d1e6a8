#pragma once

// The verdicts about the paper's findings: counts, and the box at the start of the report.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "engine/analysis/analysis.h"

namespace palpate {

// Findings by Verdict.
std::array<int, kVerdictNames.size()> verdict_counts(const OperatorAnalysis& analysis);

// "11 agree, 5 disagree, 1 not testable"
std::string verdict_counts_text(const OperatorAnalysis& analysis);

// A name for the columns of the table of verdicts_html(): "followings", or "people and simulated
// operators".
std::string columns_text(const ExperimentAnalysis& analysis);

// The indices in paper_findings() of the findings for which the columns have different verdicts.
std::vector<std::size_t> differing_findings(const ExperimentAnalysis& analysis);

// Name and statement of the findings with this verdict. The findings of the MANOVA are combined
// into one: "effects of Haptic, Rotation".
std::vector<std::pair<std::string, std::string>> findings_with(const OperatorAnalysis& analysis,
                                                               Verdict verdict);

// Whether a finding is one of the MANOVA.
bool is_multivariate(const PaperFinding& finding);

// The box: the counts, then a table with the paper's statement and figures, and the verdict of each
// following. The verdicts begin in the second column, so that the first of them fits a narrow
// screen.
std::string verdicts_html(const ExperimentAnalysis& analysis);

}  // namespace palpate
