#include "engine/experiment/canonical_report.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "engine/experiment/canonical_means.h"
#include "engine/experiment/canonical_plot.h"
#include "engine/experiment/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/report_style.h"

namespace palpate {
namespace {

constexpr int kShownDecimals = 3;

// Added to the style of all reports.
constexpr std::string_view kCanonicalStyle = R"css(
tr.groups th { border-bottom: 0; text-align: center; color: var(--quiet); }
@media (max-width: 800px) { tr.groups th { text-align: left; } }
)css";

std::string canonical_paragraph(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + html_escaped(text)) + "\n";
}

// Draws the panels of the report.
class CanonicalFigures {
 public:
  CanonicalFigures(const std::vector<CanonicalRow>& rows, std::vector<std::string>& warnings)
      : rows_(rows), warnings_(warnings) {}

  std::string figure(CanonicalMeasure measure, const std::string& id, const std::string& name,
                     const std::string& caption) {
    return "<figure class=\"" + id + "\">\n<div class=\"panels\">\n" +
           panel(measure, CanonicalMotion::kPressed, id + "-pressed-", name + ", pressed") +
           panel(measure, CanonicalMotion::kStroked, id + "-stroked-", name + ", stroked") +
           "</div>\n" + html_element("figcaption", html_escaped(caption)) + "\n</figure>\n";
  }

 private:
  std::string panel(CanonicalMeasure measure, CanonicalMotion motion, const std::string& id,
                    const std::string& name) {
    const auto svg = canonical_svg(rows_, measure, motion);
    if (svg) return inline_svg(*svg, id, name);
    warnings_.push_back(name + ": is not drawn: " + svg.error().to_string());
    return html_element("p class=\"bad\"",
                        html_escaped(name + ": no diagram: " + svg.error().to_string())) +
           "\n";
  }

  const std::vector<CanonicalRow>& rows_;
  std::vector<std::string>& warnings_;
};

std::string mean_text(const MeanInterval& interval) {
  if (interval.count == 0) return "-";
  const std::string mean = with_decimals(interval.mean, kShownDecimals);
  return interval.count < 2
             ? mean
             : mean + " \u00b1 " + with_decimals(interval.half_width, kShownDecimals);
}

std::string tangent_text(double angle_deg) {
  if (angle_deg >= 90.0) return "-";
  return with_decimals(std::tan(angle_deg * std::numbers::pi / 180.0), kShownDecimals);
}

// One row an angle; without and with rotation, of each motion.
std::string means_table(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure) {
  const bool is_ratio = measure == CanonicalMeasure::kAlongOverInto;
  std::vector<std::string> heads{"angle (deg)"};
  std::vector<std::pair<std::string, std::size_t>> groups{{"", 1}};
  if (is_ratio) heads.emplace_back("tan\u00a0a");
  if (is_ratio) groups[0].second = 2;
  std::vector<std::vector<CanonicalMean>> columns;
  for (const CanonicalMotion motion : {CanonicalMotion::kPressed, CanonicalMotion::kStroked}) {
    groups.emplace_back(kCanonicalMotionNames[static_cast<std::size_t>(motion)], 2);
    for (const bool rotates : {false, true}) {
      heads.emplace_back(rotates ? "R" : "NoR");
      columns.push_back(canonical_means(rows, measure, motion, rotates));
    }
  }
  HtmlTable table(heads, 1, groups);
  for (std::size_t i = 0; i < columns[0].size(); ++i) {
    const double angle_deg = columns[0][i].cell.angle_deg;
    std::vector<std::string> cells{number_or_dash(angle_deg)};
    if (is_ratio) cells.push_back(tangent_text(angle_deg));
    for (const auto& column : columns) cells.push_back(mean_text(column[i].interval));
    table.row(cells);
  }
  return table.html();
}

std::string canonical_reading_html() {
  return "<section id=\"reading\">\n<h2>How to read this</h2>\n" +
         canonical_paragraph(
             "What is compared?",
             "A wall without friction pushes along its normal only. With one motor, at angle a to "
             "the normal, the commanded force has a part along the wall, which no wall would have: "
             "with the wall at rest it is tan a times the part into the hand, whatever the hand "
             "does. 30 deg is the limit of Barbagli and Salisbury (2003). "
             "With R, A4 turns the wall under the hand towards the motor.") +
         canonical_paragraph(
             "Pressed and stroked",
             "The hand\u2019s target goes from outside the wall to the press depth in 1 s and is "
             "held for 2 s. A stroke then goes 100 mm along the wall, as the operator sees it. The "
             "numbers are over all ticks in contact: with R they include the time in which the "
             "wall turns.") +
         canonical_paragraph(
             "Why is there no ratio at 90 deg without rotation?",
             "The motor then lies along the wall and is not used: there is no force "
             "into the hand to divide by.") +
         canonical_paragraph(
             "Whiskers and \u00b1",
             "95 % intervals of the mean over simulated operators (Student\u2019s "
             "t). More operators make them shorter; they say nothing about people.") +
         "</section>\n";
}

std::size_t rows_without_share(const std::vector<CanonicalRow>& rows) {
  std::size_t count = 0;
  for (const CanonicalRow& row : rows) count += row.share_within_30deg ? 0 : 1;
  return count;
}

std::string canonical_facts_html(const std::vector<CanonicalRow>& rows,
                                 const CanonicalFacts& facts) {
  const std::size_t without = rows_without_share(rows);
  const std::pair<std::string, std::string> lines[] = {
      {"Plan", facts.plan_name},
      {"Seed", std::to_string(facts.seed)},
      {"Operators", std::to_string(facts.participants) + " of " + facts.operator_name},
      {"Trials", std::to_string(rows.size())},
      {"Trials without a result",
       without == 0 ? "none"
                    : std::to_string(without) +
                          " (no contact, a fault, or a hand beyond an end of the wall)"}};
  std::string out = "<section id=\"facts\">\n<h2>What was run</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : lines) {
    out += html_element("dt", name) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n</section>\n";
}

}  // namespace

std::string canonical_report_html(const std::vector<CanonicalRow>& rows,
                                  const CanonicalFacts& facts, std::vector<std::string>& warnings) {
  const std::string title = "The canonical wall, with simulated operators";
  CanonicalFigures figures(rows, warnings);
  const std::string body =
      "<header>\n" + html_element("h1", html_escaped(title)) + "\n" +
      html_element("p",
                   "A flat wall at an angle to the only motor, pressed and stroked by simulated "
                   "operators, without rotation (NoR) and with A4 (R).") +
      "\n</header>\n<main>\n<section id=\"ratio\">\n<h2>Force along the wall over force into "
      "the hand</h2>\n" +
      figures.figure(
          CanonicalMeasure::kAlongOverInto, "ratio", "Force along over force into",
          "Mean part of the commanded force along the wall, divided by its mean part "
          "along the wall\u2019s normal, over the angle of the wall at the start. Dashed: "
          "tan\u00a0a.") +
      means_table(rows, CanonicalMeasure::kAlongOverInto) +
      "</section>\n<section id=\"share\">\n<h2>Share of the contact within 30 deg</h2>\n" +
      figures.figure(
          CanonicalMeasure::kShareWithin30deg, "share", "Share within 30 deg",
          "Share of the contact in which the angle between the wall\u2019s normal and the "
          "motor is at most 30 deg.") +
      means_table(rows, CanonicalMeasure::kShareWithin30deg) + "</section>\n" +
      canonical_reading_html() + canonical_facts_html(rows, facts) + "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kCanonicalStyle), body);
}

}  // namespace palpate
