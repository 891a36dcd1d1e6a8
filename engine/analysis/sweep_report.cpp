#include "engine/analysis/sweep_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

#include "engine/analysis/sweep_plots.h"
#include "engine/analysis/sweep_tables.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/human_units.h"
#include "engine/report/report_style.h"

namespace palpate {
namespace {

constexpr const char* kSharesSentence =
    "Shares are of our ranges, not of people: they say at how many drawn hands and devices a "
    "ranking holds, and nobody knows how people are spread over these ranges.";
constexpr const char* kChanceSentence =
    "By chance alone, as if coins decided, an order of two conditions holds at 1/2 of the points, "
    "and an order of three at 1/6.";

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
.parts { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .75rem 1.5rem; }
.parts h3 { margin: .6rem 0 .2rem; }
.parts td, .parts th { padding: .25rem .45rem; font-size: .9rem; }
td strong.decides { color: #0057a3; }
.advice td:nth-child(2) { min-width: 6em; }
@media (max-width: 800px) {
  .axes, .parts { grid-template-columns: minmax(0, 1fr); }
  .advice .statement { display: none; }
}
)css";

// "71 %"; "> 99 %" and "< 1 %" for shares that are not 1 or 0 but would be rounded to them.
std::string percent(double share) {
  const long rounded = std::lround(100.0 * share);
  if (rounded == 100 && share < 1.0) return "> 99 %";
  if (rounded == 0 && share > 0.0) return "< 1 %";
  return std::to_string(rounded) + " %";
}
// "71 % of 50"
std::string part_text(const RankingShare& share) {
  if (!share.share()) return "not testable";
  return percent(*share.share()) + " of " + std::to_string(share.points);
}

std::string paragraph(const std::string& text) {
  return html_element("p", html_escaped(text)) + "\n";
}

// "71 % (61 to 79 %): holds at 71 of 100 testable points; 5 of 105 not testable, because nobody
// completed the trials"
std::string share_text(const RankingShare& share) {
  const int all = share.points + share.untestable;
  const std::string untestable = std::to_string(share.untestable) + " of " + std::to_string(all) +
                                 " not testable, because nobody completed the trials";
  if (!share.share()) return untestable;
  const Interval interval = share.interval();
  return percent(*share.share()) + " (" +
         std::to_string(static_cast<int>(std::lround(100.0 * interval.low))) + " to " +
         percent(interval.high) + "): holds at " + std::to_string(share.holds) + " of " +
         std::to_string(share.points) + " testable points" +
         (share.untestable > 0 ? "; " + untestable : "");
}

std::string symbol_text(std::size_t parameter) {
  const SweepParameter& of = sweep_parameters()[parameter];
  return of.symbol.empty() ? std::string(of.name)
                           : std::string(of.name) + " (" + std::string(of.symbol) + ")";
}

// "low half 80 % of 50, high half 40 % of 48"; "delayed 20 % of 25, frozen not testable"
std::string parts_text(const RankingHalves& halves) {
  std::string text;
  for (const RankingHalves::Part& part : halves.parts) {
    text += (text.empty() ? "" : ", ") + part.name + " " + part_text(part.share);
  }
  return text.empty() ? "-" : text;
}

// "p = 0.012"
std::string chance_text(double p) {
  std::ostringstream text;
  text << "p = " << std::setprecision(2) << p;
  return text.str();
}

// "sight_delay_s (tau): low half 80 % of 50, high half 40 % of 48 (p = 0.0005)"; several parameters
// if their parts differ equally.
std::string decisive_text(const RankingResult& result) {
  if (!result.p) return "none";
  std::string text;
  for (const std::size_t i : result.decisive()) {
    text += (text.empty() ? "" : "; ") + symbol_text(result.halves[i].parameter) + ": " +
            parts_text(result.halves[i]);
  }
  return (text.empty() ? "none beyond chance" : text) + " (" + chance_text(*result.p) + ")";
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

// What decides a point, and what Wilson's interval leaves out.
std::string persons_sentence(const SweepAnalysis& analysis) {
  std::set<int> persons;
  for (const SweepRow& row : analysis.rows) {
    if (row.block == SweepBlock::kHypercube) persons.insert(row.participant);
  }
  return "A point is decided by the means of " + std::to_string(persons.size()) +
         (persons.size() == 1 ? " person, who is" : " persons, who are") +
         " the same at all points. Wilson's interval covers the draw of the points, and not that "
         "of the persons.";
}

std::string answer_html(const SweepAnalysis& analysis) {
  const int points = analysis.point_count(SweepBlock::kHypercube);
  return "<section class=\"advice\" id=\"answer\">\n" +
         html_element("h2", "What must be true of the hand") + "\n" +
         paragraph("For each ranking that the paper reports: the share of the " +
                   std::to_string(points) +
                   " points of the hypercube at which it holds, with Wilson's 95 % interval, and "
                   "the parameter whose parts differ most in that share, if p of this largest "
                   "difference is below 0.05.") +
         paragraph(std::string(kChanceSentence) + " " + persons_sentence(analysis)) +
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

// "3 flips, 1 of them beyond noise"
std::string flips_text(const std::vector<SweepFlip>& flips) {
  const auto clear = std::count_if(flips.begin(), flips.end(),
                                   [](const SweepFlip& flip) { return flip.is_clear; });
  return std::to_string(flips.size()) + (flips.size() == 1 ? " flip, " : " flips, ") +
         std::to_string(clear) + " of them beyond noise";
}

// "Trials are missing: 40 of 120 done at frozen."; empty if none is.
std::string missing_text(const SweepAnalysis& analysis, const SweepAxis& axis) {
  std::string text;
  for (const std::size_t place : axis.points) {
    const SweepPointResult& point = analysis.points[place];
    const SweepTrials trials = trials_of(point);
    if (trials.done == trials.trials) continue;
    text += (text.empty() ? "Trials are missing: " : ", ") + std::to_string(trials.done) + " of " +
            std::to_string(trials.trials) + " done at " +
            sweep_value_text(axis.parameter, *point.rows.front().values[axis.parameter]);
  }
  return text.empty() ? text : text + ".";
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
  const std::string missing = missing_text(analysis, axis);
  if (!missing.empty()) out += paragraph(missing);
  const auto flips = flips_along(analysis, axis);
  if (flips.empty()) {
    return out + html_element("figcaption", "No ranking flips.") + "\n</figure>\n";
  }
  out += html_element("figcaption", html_escaped(flips_text(flips) + ":")) + "\n<ol>\n";
  for (const SweepFlip& flip : flips) out += flip_html(flip) + "\n";
  return out + "</ol>\n</figure>\n";
}

std::string axes_html(const SweepAnalysis& analysis, std::vector<std::string>& warnings) {
  std::string out =
      "<section id=\"one-at-a-time\">\n<h2>One parameter at a time</h2>\n" +
      paragraph(
          "In all, " + flips_text(analysis.flips) +
          ". Each figure has the means over participants at the levels of one parameter, with "
          "their standard deviations over participants; everything else is as in the base "
          "plan. Levels have equal distances. The colour states the force; open points and "
          "dashed lines are without rotation. A vertical line marks where a ranking flips "
          "against the last level at which it is testable, with its number in the list below the "
          "figure: a solid line if the 95 % intervals of the paired differences at both levels "
          "exclude 0; a dashed line and a number in parentheses if the flip is within the noise "
          "of so few persons. At a shaded level, trials are missing: its means are over the "
          "persons who completed all trials of a condition, and the total time counts the limit "
          "for a timeout.") +
      "<div class=\"axes\">\n";
  for (const SweepAxis& axis : analysis.axes) out += axis_html(analysis, axis, warnings);
  return out + "</div>\n</section>\n";
}

std::string ranking_parts_html(const SweepRanking& ranking, const RankingResult& result) {
  const auto decisive = result.decisive();
  HtmlTable table({"parameter", "holds at"}, 2);
  for (std::size_t i = 0; i < result.halves.size(); ++i) {
    const std::string text = html_escaped(parts_text(result.halves[i]));
    const bool decides = std::find(decisive.begin(), decisive.end(), i) != decisive.end();
    table.row({html_escaped(symbol_text(result.halves[i].parameter)),
               decides ? html_element("strong class=\"decides\"", text) : text});
  }
  return "<div>\n" + html_element("h3", html_escaped(ranking.name + ": " + ranking.order())) +
         "\n" + table.html() + "</div>\n";
}

std::string halves_html(const SweepAnalysis& analysis) {
  std::string tables;
  for (std::size_t i = 0; i < analysis.rankings.size(); ++i) {
    tables += ranking_parts_html(sweep_rankings()[i], analysis.rankings[i]);
  }
  return "<section id=\"halves\">\n<h2>The halves of the hypercube</h2>\n" +
         paragraph(
             "The share of testable points at which a ranking holds, in the low and in the high "
             "half of each parameter, or at each of its words, and their number of points. Bold: "
             "the parameter whose parts "
             "differ most, if p of this largest difference is below 0.05.") +
         "<div class=\"parts\">\n" + tables + "</div>\n</section>\n";
}

std::string explained(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + html_escaped(text)) + "\n";
}

std::string reading_html() {
  return "<section id=\"reading\">\n<h2>How to read this</h2>\n" +
         explained("A ranking",
                   "is an order of two or three conditions by the mean of a measure over "
                   "participants. For losses, penetration and angle, a participant counts at a "
                   "point only if all trials of all cells of the ranking were done: of all six for "
                   "rankings of Haptic and of Rotation, of both of UaH for the contact angle and "
                   "for the rankings of A4. All conditions are then compared by the same objects. "
                   "The total time counts a timeout with the time limit, and a participant counts "
                   "with one done trial or more. A fault leaves a participant out. The ranking "
                   "holds if each mean is below the next. The paper finds no effect of Rotation on "
                   "the penetration, so that this is no ranking.") +
         explained("The halves",
                   "of a parameter are the points with the first half of its values in ascending "
                   "order and those with the last half. The middle of an odd number of values "
                   "belongs to neither. Each word of following and align is a part of its own.") +
         explained("The parameter that decides most",
                   "has the largest of many differences. A permutation test states p: the share "
                   "of 2,000 random deals of the same results to the points in which the largest "
                   "difference of all parameters is as large. If p is 0.05 or more, no parameter "
                   "decides beyond chance.") +
         explained("Missing trials.",
                   "The means in sweep.csv are over the trials that ended at the red sphere. Where "
                   "many do not, they are means of the easier trials; rankings and figures leave "
                   "such persons out, or count the time limit. A ranking is not testable at a "
                   "point where no person counts.") +
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
  return text + kChanceSentence + " " + persons_sentence(analysis) + "\n" + kSharesSentence + "\n";
}

}  // namespace palpate
