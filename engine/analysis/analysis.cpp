#include "engine/analysis/analysis.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

#include "engine/analysis/statistics_text.h"

namespace palpate {
namespace {

// The only value of an outcome, if it has no other.
std::optional<double> constant_value(const TrialTable& table, Outcome outcome) {
  std::optional<double> first;
  for (int p = 0; p < static_cast<int>(table.participants().size()); ++p) {
    for (int c = 0; c < table.conditions(); ++c) {
      for (int t = 0; t < table.level_count(kTrialFactor); ++t) {
        const auto value = table.value(p, c, t, outcome);
        if (!value) continue;
        if (first && *first != *value) return std::nullopt;
        first = value;
      }
    }
  }
  return first;
}

Error in_following(Error error, const TrialTable& table) {
  error.element = table.whose() + error.element;
  return error;
}

// The factors that no analysis has. The paper's analysis names them too, if it is possible.
std::vector<std::string> single_level_notes(const TrialTable& table) {
  std::vector<std::string> notes;
  for (const ExperimentFactor f : {kHapticFactor, kRotationFactor, kObjectFactor, kTrialFactor}) {
    if (table.level_count(f) > 1) continue;
    notes.push_back(std::string(kExperimentFactorNames[f]) +
                    " is left out, because the file has one level of it: " + table.levels(f)[0] +
                    ".");
  }
  return notes;
}

// is_one_of_several: the file has other variants, with which this one can be compared.
std::optional<Error> analyse_outcomes(OperatorAnalysis& analysis, bool is_one_of_several) {
  const TrialTable& table = analysis.table;
  for (const Outcome outcome :
       {Outcome::kTime, Outcome::kLosses, Outcome::kPenetration, Outcome::kContactAngle,
        Outcome::kLossesPerSecond, Outcome::kLosses100ms, Outcome::kTimeToLimit}) {
    const OutcomeText& text = outcome_text(outcome);
    if (outcome == Outcome::kTimeToLimit && analysis.counts.timeouts == 0) continue;
    if (!table.has(outcome)) {
      analysis.notes.push_back(
          (table.has_completed_trial()
               ? "The file does not have the column " + std::string(text.column)
               : std::string("No trial was completed")) +
          ", so that there is no analysis of " + std::string(text.name) + ".");
      continue;
    }
    if (const auto value = constant_value(table, outcome)) {
      if (outcome == Outcome::kContactAngle && !is_one_of_several) {
        return invalid_argument(
            std::string(text.column),
            "is " + number_or_dash(*value) + " in every trial; expected a measure that varies",
            "check the column");
      }
      analysis.notes.push_back("The number of " + std::string(text.name) + " is " +
                               number_or_dash(*value) +
                               " in every trial; its analysis is left out.");
      continue;
    }
    analysis.primary.push_back(analyse_repeated_measures(table, outcome));
  }
  const auto& haptic = table.levels(kHapticFactor);
  const auto uah = std::find(haptic.begin(), haptic.end(), "UaH");
  if (uah != haptic.end() && table.has(Outcome::kContactAngle)) {
    analysis.angle_of_uah = analyse_repeated_measures(table, Outcome::kContactAngle,
                                                      static_cast<int>(uah - haptic.begin()));
  }
  return std::nullopt;
}

// A condition without a completed trial makes the paper's analysis impossible, and is no error. If
// the file has several variants, no other reason is one either: they are still compared.
std::optional<Error> analyse_fixed_effects(OperatorAnalysis& analysis, bool is_one_of_several) {
  const auto empty = std::find_if(analysis.by_condition.begin(), analysis.by_condition.end(),
                                  [](const TrialCounts& counts) { return counts.done == 0; });
  auto paper = analyse_as_paper(analysis.table);
  if (paper) {
    analysis.paper = std::move(*paper);
    for (const std::string& sentence : analysis.paper->left_out) {
      if (std::find(analysis.notes.begin(), analysis.notes.end(), sentence) ==
          analysis.notes.end()) {
        analysis.notes.push_back(sentence);
      }
    }
    return std::nullopt;
  }
  if (empty == analysis.by_condition.end() && is_one_of_several) {
    analysis.paper_problem = "The trials " + paper.error().problem + ".";
    return std::nullopt;
  }
  if (empty == analysis.by_condition.end()) return paper.error();
  analysis.paper_problem = "No trial of " + levels_name(analysis.table, empty->at) +
                           " was completed: its effects cannot be separated.";
  return std::nullopt;
}

Result<OperatorAnalysis> analyse_table(TrialTable table, bool is_one_of_several) {
  OperatorAnalysis analysis{std::move(table), {}, "", {}, {}, {}, {}, {}, {}};
  analysis.counts = trial_counts(analysis.table, {});
  analysis.by_condition = counts_by_condition(analysis.table);
  analysis.notes = single_level_notes(analysis.table);
  if (analysis.table.earlier_attempts() > 0) {
    analysis.notes.push_back(
        "Of several attempts at a trial the last one counts; rows of earlier attempts: " +
        std::to_string(analysis.table.earlier_attempts()) + ".");
  }
  if (auto error = analyse_fixed_effects(analysis, is_one_of_several))
    return in_following(*error, analysis.table);
  if (auto error = analyse_outcomes(analysis, is_one_of_several))
    return in_following(*error, analysis.table);
  analysis.findings =
      judge_findings(analysis.table, analysis.paper, analysis.primary, analysis.angle_of_uah);
  return analysis;
}

}  // namespace

std::string OperatorAnalysis::name() const {
  TrialVariant plain;
  if (is_simulated()) plain.view = table.variant().view;  // the following names it
  const std::string variant = variant_name(table.variant(), plain);
  return following() + (variant.empty() ? "" : ", " + variant);
}

std::string OperatorAnalysis::following() const {
  return is_simulated() ? table.following() : "people";
}

std::string OperatorAnalysis::anchor() const {
  std::string text;
  for (const char c : name()) {
    if (c == ' ') text += '-';
    if (c == '+') text += 'p';  // of an exponent
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-') text += c;
  }
  return text;
}

const PrimaryAnalysis* OperatorAnalysis::primary_of(Outcome outcome) const {
  const auto found =
      std::find_if(primary.begin(), primary.end(),
                   [&](const PrimaryAnalysis& analysis) { return analysis.outcome == outcome; });
  return found == primary.end() ? nullptr : &*found;
}

bool ExperimentAnalysis::has_simulated() const {
  return std::any_of(operators.begin(), operators.end(),
                     [](const OperatorAnalysis& analysis) { return analysis.is_simulated(); });
}

int ExperimentAnalysis::variants() const {
  std::set<TrialVariant> found;
  for (const OperatorAnalysis& each : operators) found.insert(each.table.variant());
  return static_cast<int>(found.size());
}

bool ExperimentAnalysis::has_people() const {
  return !std::all_of(operators.begin(), operators.end(),
                      [](const OperatorAnalysis& analysis) { return analysis.is_simulated(); });
}

Result<ExperimentAnalysis> analyse_trials(std::vector<TrialRow> rows, double limit_s) {
  auto tables = trial_tables(std::move(rows), limit_s);
  if (!tables) return tables.error();
  ExperimentAnalysis analysis;
  std::set<TrialVariant> variants;
  for (const TrialTable& table : *tables) variants.insert(table.variant());
  for (TrialTable& table : *tables) {
    auto of_operator = analyse_table(std::move(table), variants.size() > 1);
    if (!of_operator) return of_operator.error();
    analysis.operators.push_back(std::move(*of_operator));
  }
  std::vector<const TrialTable*> of_operators;
  for (const OperatorAnalysis& each : analysis.operators) of_operators.push_back(&each.table);
  analysis.differences = variant_differences(of_operators);
  const bool any_paper =
      std::any_of(analysis.operators.begin(), analysis.operators.end(),
                  [](const OperatorAnalysis& each) { return each.paper.has_value(); });
  if (!any_paper && variants.size() == 1) {
    const auto paper = analyse_as_paper(analysis.operators[0].table);
    return in_following(paper.error(), analysis.operators[0].table);
  }
  return analysis;
}

}  // namespace palpate
