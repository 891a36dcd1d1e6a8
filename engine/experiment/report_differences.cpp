#include "engine/experiment/report_differences.h"

#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "engine/experiment/intervals.h"
#include "engine/experiment/statistics_tables.h"
#include "engine/experiment/statistics_text.h"
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

std::string differences_table(const ExperimentAnalysis& analysis) {
  const std::vector<Outcome> outcomes = outcomes_of(analysis.differences);
  std::vector<std::string> heads = {"difference", "condition"};
  for (const Outcome outcome : outcomes) heads.push_back(html_escaped(outcome_heading(outcome)));
  HtmlTable table(heads, 2);
  // A row for each pair and condition, in the order in which they first occur.
  using RowKey = std::pair<std::string, std::string>;
  std::vector<RowKey> rows;
  std::map<RowKey, std::map<Outcome, std::string>> cells;
  for (const VariantDifference& difference : analysis.differences) {
    const RowKey key = {pair_name(analysis, difference),
                        difference.haptic + ", " + difference.rotation};
    if (!cells.contains(key)) rows.push_back(key);
    cells[key][difference.outcome] = difference_cell(difference.test, difference.outcome);
  }
  std::string before;
  for (const RowKey& key : rows) {
    std::vector<std::string> row = {key.first == before ? "" : html_escaped(key.first),
                                    html_escaped(key.second)};
    before = key.first;
    for (const Outcome outcome : outcomes) {
      const auto found = cells[key].find(outcome);
      row.push_back(found == cells[key].end() ? "-" : found->second);
    }
    table.row(row);
  }
  return table.html();
}

bool has_still_view(const ExperimentAnalysis& analysis) {
  for (const OperatorAnalysis& each : analysis.operators) {
    if (each.table.variant().view == "still") return true;
  }
  return false;
}

}  // namespace

std::string differences_html(const ExperimentAnalysis& analysis) {
  if (analysis.variants() == 1) return "";
  std::string out =
      "<section class=\"operator\" id=\"differences\">\n<h2>Differences between settings</h2>\n" +
      html_element(
          "p",
          "The file has several levels of view, align, start orientation or scale. Each "
          "combination is an experiment of its own with the same persons and random "
          "numbers. A difference is the mean over participants (their number follows) of "
          "their mean differences between trials with the same object and block, \u00b1 "
          "half of its 95 % interval by Student\u2019s t, not adjusted for the number of "
          "comparisons. It is bold if the interval does not hold 0. A trial counts only if "
          "both were completed.") +
      "\n";
  if (has_still_view(analysis)) {
    out += html_element("p",
                        "Whether the turning view helps hangs on one assumption: how far a person "
                        "adapts to a hand that moves in another direction than its picture. A "
                        "simulated person who adapts wholly (adapts-1) has the belief of one who "
                        "sees the scene turn (delayed), but for rounding; their trials part in the "
                        "end, because a person decides at thresholds, and their mean differences "
                        "show how much of a difference is chance. The other two persons show what "
                        "less adaptation costs.") +
           "\n";
  }
  return out + differences_table(analysis) + "</section>\n";
}

}  // namespace palpate
