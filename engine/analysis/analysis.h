#pragma once

// Analyses the trials of an experiment, by people or by simulated operators, in two ways: as the
// paper did, and by repeated measures, which is the primary analysis. The trials of each following
// (levels.h) and of each variant (trial_variant.h) are analysed separately.

#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/paper_analysis.h"
#include "engine/analysis/paper_findings.h"
#include "engine/analysis/primary_analysis.h"
#include "engine/analysis/trial_means.h"
#include "engine/analysis/trial_table.h"
#include "engine/analysis/variant_differences.h"
#include "geometry/base/result.h"

namespace palpate {

// The analysis of the trials of one following, or of the trials of people.
struct OperatorAnalysis {
  TrialTable table;
  std::optional<PaperAnalysis> paper;  // no value: paper_problem states why
  std::string paper_problem;
  std::vector<PrimaryAnalysis> primary;         // all levels of Haptic, one for each outcome
  std::optional<PrimaryAnalysis> angle_of_uah;  // Figure 7
  TrialCounts counts;                           // of all conditions together
  std::vector<TrialCounts> by_condition;
  std::vector<FindingResult> findings;  // in the order of paper_findings()
  std::vector<std::string> notes;       // what was left out, and why: sentences

  bool is_simulated() const { return !table.following().empty(); }
  // "delayed"; "people"; "delayed, start 45 deg"
  std::string name() const;
  // "delayed"; "people"
  std::string following() const;
  // name() as an id in a page.
  std::string anchor() const;
  const PrimaryAnalysis* primary_of(Outcome outcome) const;
};

struct ExperimentAnalysis {
  std::vector<OperatorAnalysis> operators;     // at least one, in the order of trial_tables()
  std::vector<VariantDifference> differences;  // between operators; none with one variant
  int variants() const;
  bool has_simulated() const;
  bool has_people() const;
};

// rows: the rows of trials.csv. Their order has no influence on the result.
//
// Errors: those of trial_tables() and analyse_as_paper(), and a contact angle that is the same in
// all trials. A condition without a completed trial is an error only if every following has such a
// condition.
Result<ExperimentAnalysis> analyse_trials(std::vector<TrialRow> rows, double limit_s);

}  // namespace palpate
