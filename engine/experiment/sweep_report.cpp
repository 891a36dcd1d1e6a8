#include "engine/experiment/sweep_report.h"

#include <algorithm>
#include <cmath>

#include "engine/experiment/dealt_merge.h"
#include "engine/experiment/sweep_plots.h"
#include "engine/experiment/sweep_run.h"
#include "engine/experiment/sweep_tables.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/human_units.h"
#include "engine/report/report_style.h"

namespace palpate {
namespace {

constexpr const char* kSweepPage = "report.html";
constexpr const char* kSweepJson = "sweep.json";
constexpr const char* kSharesSentence =
    "Shares are of our ranges, not of people: they say at how many drawn hands and devices a "
    "ranking holds, and nobody knows how people are spread over these ranges.";

// Added to the style of all reports.
constexpr std::string_view kSweepStyle = R"css(
.advice .wide { background: #fff; border: 1px solid var(--line); border-radius: 6px; }
.axes { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .75rem 1.5rem; }
.axes figure { min-width: 0; }
.axes svg { display: block; width: 100%; max-width: 560px; height: auto; }
.axes h3 { margin: .6rem 0 .2rem; }
.axes ol { margin: .2rem 0; padding-left: 1.4rem; font-size: .9rem; }
.unclear { color: var(--quiet); }
details > summary { cursor: pointer; color: #0057a3; margin: .8rem 0; }
.halves td, .halves th { padding: .25rem .45rem; }
td strong.decides { color: #0057a3; }
.advice td:nth-child(2) { min-width: 6em; }
@media (max-width: 800px) {
  .axes { grid-template-columns: minmax(0, 1fr); }
  .advice .statement { display: none; }
}
)css";

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %";
}
std::string percent(const std::optional<double>& share) {
  return share ? percent(*share) : "-";
}

std::string paragraph(const std::string& text) {
  return html_element("p", html_escaped(text)) + "\n";
}

// "71 % (61 to 79 %) of 100 points"
std::string share_text(const RankingShare& share) {
  if (!share.share()) return "not testable";
  const Interval interval = share.interval();
  return percent(*share.share()) + " (" +
         std::to_string(static_cast<int>(std::lround(100.0 * interval.low))) + " to " +
         percent(interval.high) + ") of " + std::to_string(share.points) + " points";
}

std::string symbol_text(std::size_t parameter) {
  const SweepParameter& of = sweep_parameters()[parameter];
  return of.symbol.empty() ? std::string(of.name)
                           : std::string(of.name) + " (" + std::string(of.symbol) + ")";
}

// "sight_delay_s (tau): 80 % in the low half, 40 % in the high half"; several parameters if their
// halves differ equally.
std::string decisive_text(const RankingResult& result) {
  std::string text;
  for (const std::size_t i : result.decisive) {
    const RankingHalves& halves = result.halves[i];
    text += (text.empty() ? "" : "; ") + symbol_text(halves.parameter) + ": " +
            percent(halves.low.share()) + " in the low half, " + percent(halves.high.share()) +
            " in the high half";
  }
  return text.empty() ? "none" : text;
}

std::string rankings_html(const SweepAnalysis& analysis, bool is_of_paper) {
  HtmlTable table({"ranking", "holds at", "what decides most"}, 3);
  for (std::size_t i = 0; i < analysis.rankings.size(); ++i) {
    const SweepRanking& ranking = sweep_rankings()[i];
    if (ranking.is_of_paper != is_of_paper) continue;
    const RankingResult& result = analysis.rankings[i];
    table.row({html_escaped(ranking.name) + ": " +
                   html_element("strong", html_escaped(ranking.order())) +
                   html_element("span class=\"spread statement\"",
                                "<br>" + html_escaped(ranking.statement)),
               html_escaped(share_text(result.all)), html_escaped(decisive_text(result))});
  }
  return table.html();
}

std::string answer_html(const SweepAnalysis& analysis) {
  const int points = analysis.point_count(SweepBlock::kHypercube);
  return "<section class=\"advice\" id=\"answer\">\n" +
         html_element("h2", "What must be true of the hand") + "\n" +
         paragraph("For each ranking that the paper reports: the share of the " +
                   std::to_string(points) +
                   " points of the hypercube at which it holds, with Wilson's 95 % interval, and "
                   "the parameter whose halves differ most in that share.") +
         rankings_html(analysis, true) +
         html_element("h3", "Does A4 help where the force is along the motor?") + "\n" +
         paragraph(
             "The same for the other measures of UaH: that they are smaller with rotation. "
             "For the contact angle, it is the last ranking above.") +
         rankings_html(analysis, false) +
         html_element("p", html_element("strong", html_escaped(kSharesSentence))) +
         "\n</section>\n";
}

std::string flip_html(const SweepFlip& flip) {
  const SweepRanking& ranking = sweep_rankings()[flip.ranking];
  const auto value = [&](double level) { return sweep_value_text(flip.parameter, level); };
  const std::string text = ranking.name + " (" + ranking.order() + "): holds at " +
                           value(flip.holds_at_to ? flip.to : flip.from) + ", not at " +
                           value(flip.holds_at_to ? flip.from : flip.to);
  if (flip.is_clear) return html_element("li", html_escaped(text));
  return html_element("li class=\"unclear\"", html_escaped(text + " (within noise)"));
}

std::string axis_html(const SweepAnalysis& analysis, const SweepAxis& axis,
                      std::vector<std::string>& warnings) {
  const std::string name(sweep_parameters()[axis.parameter].name);
  const std::string title = symbol_text(axis.parameter);
  std::string out =
      "<figure id=\"" + name + "\">\n" + html_element("h3", html_escaped(title)) + "\n";
  const auto svg = sweep_axis_svg(analysis, axis);
  if (svg) {
    out += inline_svg(*svg, name, "The measures of the six conditions by " + name);
  } else {
    warnings.push_back("the figure of " + name + " is missing: " + svg.error().to_string());
    out += paragraph("This figure could not be drawn; one_at_a_time.csv has its numbers.");
  }
  const auto flips = flips_along(analysis, axis);
  if (flips.empty()) {
    return out + html_element("figcaption", "No ranking flips.") + "\n</figure>\n";
  }
  out += html_element("figcaption", "Rankings that flip:") + "\n<ol>\n";
  for (const SweepFlip& flip : flips) out += flip_html(flip) + "\n";
  return out + "</ol>\n</figure>\n";
}

std::string axes_html(const SweepAnalysis& analysis, std::vector<std::string>& warnings) {
  std::string out =
      "<section id=\"one-at-a-time\">\n<h2>One parameter at a time</h2>\n" +
      paragraph(
          "Each figure has the means over participants at the levels of one parameter, with "
          "their standard deviations over participants; everything else is as in the base "
          "plan. Levels have equal distances. The colour states the force; open points and "
          "dashed lines are without rotation. A vertical line marks where a ranking flips, "
          "with its number in the list below the figure: solid if the 95 % intervals of the "
          "paired differences at both levels exclude 0, dashed if the flip is within the "
          "noise of so few persons.") +
      "<div class=\"axes\">\n";
  for (const SweepAxis& axis : analysis.axes) out += axis_html(analysis, axis, warnings);
  return out + "</div>\n</section>\n";
}

std::string halves_html(const SweepAnalysis& analysis) {
  std::vector<std::string> heads{"parameter"};
  for (const SweepRanking& ranking : sweep_rankings()) heads.push_back(ranking.name);
  HtmlTable table(heads);
  for (std::size_t i = 0; i < analysis.parameters.size(); ++i) {
    std::vector<std::string> cells{html_escaped(symbol_text(analysis.parameters[i]))};
    for (const RankingResult& result : analysis.rankings) {
      const RankingHalves& halves = result.halves[i];
      const std::string text =
          html_escaped(percent(halves.low.share()) + " \u2192 " + percent(halves.high.share()));
      const bool decides =
          std::find(result.decisive.begin(), result.decisive.end(), i) != result.decisive.end();
      cells.push_back(decides ? html_element("strong class=\"decides\"", text) : text);
    }
    table.row(cells);
  }
  return "<section class=\"halves\" id=\"halves\">\n<h2>The halves of the hypercube</h2>\n" +
         paragraph(
             "The share of points at which a ranking holds, in the low and in the high half "
             "of each parameter. Bold: the parameter whose halves differ most.") +
         table.html() + "</section>\n";
}

std::string explained(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + html_escaped(text)) + "\n";
}

std::string reading_html() {
  return "<section id=\"reading\">\n<h2>How to read this</h2>\n" +
         explained("A ranking",
                   "is an order of two or three conditions by the mean of a measure over "
                   "participants. A participant counts if it completed a trial in each cell of the "
                   "ranking: in all six for rankings of Haptic and of Rotation, in both of UaH for "
                   "the contact angle and for the rankings of A4. The ranking holds if each mean "
                   "is below the next. The paper finds no effect of Rotation on the penetration, "
                   "so that this is no ranking.") +
         explained("The halves",
                   "of a parameter are the points with the first half of its values in ascending "
                   "order and those with the last half. The middle of an odd number of values "
                   "belongs to neither. Words are in the order of the tables: delayed, predict, "
                   "replan, frozen; nearest, forward.") +
         explained("The parameter that decides most",
                   "is the largest of many differences, some of which are chance: with 100 points, "
                   "halves of equal shares differ by 20 points of a percent or more in one of "
                   "twenty.") +
         explained("Missing trials.",
                   "Means are over the trials that ended at the red sphere. Where many do not, "
                   "they are means of the easier trials. sweep.csv has the numbers.") +
         explained("The persons and their random numbers",
                   "are the same at all points, apart from what a point sets.") +
         "</section>\n";
}

std::string values_text(const SweepAnalysis& analysis, std::size_t parameter) {
  double low = INFINITY, high = -INFINITY;
  for (const SweepRow& row : analysis.rows) {
    if (row.block != SweepBlock::kHypercube) continue;
    low = std::min(low, *row.values[parameter]);
    high = std::max(high, *row.values[parameter]);
  }
  const std::string unit(sweep_parameters()[parameter].unit);
  return sweep_value_text(parameter, low) + " to " + sweep_value_text(parameter, high) +
         (unit.empty() || unit == "1" ? "" : " " + unit);
}

std::string facts_html(const SweepAnalysis& analysis, const RunIdentity& identity) {
  std::uint64_t trials = 0, done = 0;
  for (const SweepRow& row : analysis.rows) {
    trials += static_cast<std::uint64_t>(row.trials);
    done += static_cast<std::uint64_t>(row.done);
  }
  std::vector<std::pair<std::string, std::string>> facts = {
      {"Sweep", identity.plan_name},
      {"Points",
       std::to_string(analysis.point_count(SweepBlock::kBase)) + " base, " +
           std::to_string(analysis.point_count(SweepBlock::kOneAtATime)) + " one at a time, " +
           std::to_string(analysis.point_count(SweepBlock::kHypercube)) + " of the hypercube"},
      {"Trials",
       std::to_string(trials) + ", of which " + std::to_string(done) + " ended at the red sphere"},
      {"Operator",
       identity.operator_name + ", version " + std::to_string(identity.operator_version)},
      {"Palpate", identity.version}};
  for (const std::size_t parameter : analysis.parameters) {
    facts.emplace_back("Drawn " + std::string(sweep_parameters()[parameter].name),
                       values_text(analysis, parameter));
  }
  std::string out = "<section id=\"facts\">\n<h2>What was run</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    out += html_element("dt", html_escaped(name)) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n</section>\n";
}

std::string sweep_html(const SweepAnalysis& analysis, const RunIdentity& identity,
                       std::vector<std::string>& warnings) {
  const std::string title = "Which assumptions about the hand decide: " + identity.plan_name;
  const std::string out =
      "<header>\n" + html_element("h1", html_escaped(title)) + "\n" +
      paragraph(
          "Simulated operators repeat the experiment of Lecuyer et al. (2005) with other "
          "assumptions about the hand, the device and the rule of rotation.") +
      "</header>\n<main>\n" + answer_html(analysis) + axes_html(analysis, warnings) +
      halves_html(analysis) + reading_html() + facts_html(analysis, identity) + "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kSweepStyle), out);
}

}  // namespace

std::vector<std::string> sweep_result_names() {
  std::vector<std::string> names{kSweepFile, kSweepPage, kSweepJson};
  for (const std::string_view name : kSweepTableNames) names.push_back(std::string(name) + ".csv");
  names.emplace_back(kRunFile);
  return names;
}

std::vector<std::pair<std::string, std::string>> sweep_report(const SweepAnalysis& analysis,
                                                              const RunIdentity& identity,
                                                              std::vector<std::string>& warnings) {
  std::vector<std::pair<std::string, std::string>> files = {
      {kSweepPage, sweep_html(analysis, identity, warnings)},
      {kSweepJson, sweep_json(analysis, identity.plan_name)}};
  for (const ResultTable& table : sweep_tables(analysis)) {
    files.emplace_back(table.name + ".csv", csv_of(table));
  }
  return files;
}

std::string sweep_text(const SweepAnalysis& analysis) {
  std::string text;
  for (std::size_t i = 0; i < analysis.rankings.size(); ++i) {
    const SweepRanking& ranking = sweep_rankings()[i];
    const RankingResult& result = analysis.rankings[i];
    text += "  " + ranking.name + " (" + ranking.order() + "): " + share_text(result.all) +
            "; decides most: " + decisive_text(result) + "\n";
  }
  return text + kSharesSentence + "\n";
}

}  // namespace palpate
