#pragma once

// All numbers of an analysis, for other programs.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/analysis.h"
#include "engine/analysis/result_table.h"

namespace palpate {

// The file that is analysed, and the time limit of its trials.
struct TrialSource {
  std::string file;  // as the user named it
  double limit_s = 120.0;
};

// The names of the tables, which are those of the CSV files, in the order of analysis_tables().
inline constexpr std::array<std::string_view, 6> kAnalysisTableNames = {
    "effects", "comparisons", "means", "missing_trials", "findings", "differences"};

// Every F, every comparison, every mean, the missing trials by condition, the verdicts, and the
// differences between variants, which are none in a file with one variant.
std::vector<ResultTable> analysis_tables(const ExperimentAnalysis& analysis);

// The tables as one JSON document, which begins with the file, the time limit and the operators.
std::string analysis_json(const ExperimentAnalysis& analysis, const TrialSource& source);

// The analysed outcomes, in the order of the reports: those that the trials have. kTimeToLimit is
// among them only if there are timeouts.
std::vector<Outcome> reported_outcomes(const OperatorAnalysis& analysis);

// The paper's mean of an outcome at these levels, if it has one. The paper's contact angles are
// those of UaH.
const PaperMean* paper_mean_at(const TrialTable& table, Outcome outcome, const TrialLevels& at);

// The paper's line of an effect in the MANOVA, if it has one.
const PaperLambda* paper_lambda(const FactorSet& term);

// Whether one following agrees with a finding and another one disagrees.
bool verdicts_differ(const ExperimentAnalysis& analysis, std::size_t finding);

}  // namespace palpate
