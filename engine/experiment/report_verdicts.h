#pragma once

// What agrees with the paper's findings and what does not: counts, and the box that the report
// begins with.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "engine/experiment/analysis.h"

namespace palpate {

// Findings by Verdict.
std::array<int, kVerdictNames.size()> verdict_counts(const OperatorAnalysis& analysis);

// "11 agree, 5 disagree, 1 not testable"
std::string verdict_counts_text(const OperatorAnalysis& analysis);

// What the columns of the table are: "followings", or "people and simulated operators".
std::string columns_text(const ExperimentAnalysis& analysis);

// The places in paper_findings() of the findings about which the columns differ.
std::vector<std::size_t> differing_findings(const ExperimentAnalysis& analysis);

// Name and statement of the findings with a verdict. Those of the MANOVA are one: "effects of
// Haptic, Rotation".
std::vector<std::pair<std::string, std::string>> findings_with(const OperatorAnalysis& analysis,
                                                               Verdict verdict);

// Whether a finding is one of the MANOVA.
bool is_multivariate(const PaperFinding& finding);

// The box: the counts, then a table with the paper's statement and figures, and the verdict of each
// following. The verdicts stand second, so that the leading one fits a narrow screen.
std::string verdicts_html(const ExperimentAnalysis& analysis);

}  // namespace palpate
