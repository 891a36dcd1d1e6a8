#include "engine/analysis/report_differences.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "engine/analysis/intervals.h"
#include "engine/analysis/statistics_tables.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"

namespace palpate {
namespace {

// "1.3 ± 0.4 (10)", in bold if the interval does not hold 0.
std::string difference_cell(const PairedT& test, Outcome outcome) {
  if (test.pairs == 0) return "-";
  const int decimals = outcome == Outcome::kPenetration ? 4 : 2;
  const std::string text =
      html_escaped(mean_with_interval(test.difference, test.half_width, decimals) + " (" +
                   std::to_string(test.pairs) + ")");
  return std::abs(test.difference) > test.half_width ? html_element("strong", text) : text;
}

// "delayed, start 45 deg − delayed"
std::string pair_name(const ExperimentAnalysis& analysis, const VariantDifference& difference) {
  return analysis.operators[difference.second].name() + " \u2212 " +
         analysis.operators[difference.first].name();
}

// The outcomes that occur, in their order.
std::vector<Outcome> outcomes_of(const std::vector<VariantDifference>& differences) {
  std::vector<Outcome> outcomes;
  std::set<Outcome> known;
  for (const VariantDifference& difference : differences) {
    if (known.insert(difference.outcome).second) outcomes.push_back(difference.outcome);
  }
  return outcomes;
}

// The differences of one pair: a row for each condition, a cell for each outcome.
struct PairRows {
  std::string name;
  std::vector<std::string> conditions;
  std::map<std::string, std::map<Outcome, std::string>> cells;  // by condition
};

// The differences of a pair follow each other.
std::vector<PairRows> rows_of_pairs(const ExperimentAnalysis& analysis) {
  std::vector<PairRows> pairs;
  const VariantDifference* before = nullptr;
  for (const VariantDifference& difference : analysis.differences) {
    if (!before || before->first != difference.first || before->second != difference.second) {
      pairs.push_back({pair_name(analysis, difference), {}, {}});
    }
    before = &difference;
    PairRows& pair = pairs.back();
    const std::string condition = difference.haptic + ", " + difference.rotation;
    if (!pair.cells.contains(condition)) pair.conditions.push_back(condition);
    pair.cells[condition][difference.outcome] =
        difference_cell(difference.test, difference.outcome);
  }
  return pairs;
}

std::string differences_table(const ExperimentAnalysis& analysis) {
  const std::vector<Outcome> outcomes = outcomes_of(analysis.differences);
  std::vector<std::string> heads = {"difference", "condition"};
  for (const Outcome outcome : outcomes) heads.push_back(outcome_heading(outcome));
  HtmlTable table(heads, 2);
  for (const PairRows& pair : rows_of_pairs(analysis)) {
    std::string name = html_escaped(pair.name);
    for (const std::string& condition : pair.conditions) {
      std::vector<std::string> row = {std::exchange(name, ""), html_escaped(condition)};
      const auto& cells = pair.cells.at(condition);
      for (const Outcome outcome : outcomes) {
        row.push_back(cells.contains(outcome) ? cells.at(outcome) : "-");
      }
      table.row(row);
    }
  }
  return table.html();
}

// Whether simulated persons see the scene still.
bool has_adaptations(const ExperimentAnalysis& analysis) {
  for (const OperatorAnalysis& each : analysis.operators) {
    if (each.is_simulated() && each.table.variant().view == "still") return true;
  }
  return false;
}

std::string method_html() {
  return html_element(
             "p",
             "The file has several levels of view, align, start orientation or scale. Each "
             "combination is an experiment of its own; those of a plan have the same persons and "
             "random numbers. The table compares combinations that differ in one of these "
             "settings. A difference is the mean over participants (their number follows) of their "
             "mean differences between trials with the same object and block, \u00b1 half of its "
             "95 % interval by Student\u2019s t, not adjusted for the number of comparisons. It is "
             "bold if the interval does not hold 0. A pair of trials counts if both have the "
             "measure.") +
         "\n";
}

std::string adaptations_html() {
  return html_element(
             "p",
             "Whether the turning view helps hangs on one assumption: how far a person adapts to a "
             "hand that moves in another direction than its picture. A simulated person who adapts "
             "wholly (adapts-1) has the belief of one who sees the scene turn (delayed), and the "
             "same trials. The other two show what less adaptation costs.") +
         "\n";
}

}  // namespace

std::string differences_html(const ExperimentAnalysis& analysis) {
  if (analysis.variants() == 1) return "";
  return "<section class=\"operator\" id=\"differences\">\n<h2>Differences between "
         "settings</h2>\n" +
         method_html() + (has_adaptations(analysis) ? adaptations_html() : "") +
         differences_table(analysis) + "</section>\n";
}

}  // namespace palpate
