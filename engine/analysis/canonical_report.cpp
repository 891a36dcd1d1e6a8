#include "engine/analysis/canonical_report.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/analysis/canonical_means.h"
#include "engine/analysis/canonical_plot.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/report_style.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

constexpr int kShownDecimals = 3;

// Added to the style of all reports: the number of operators below a mean, so that the table fits a
// narrow screen.
constexpr std::string_view kCanonicalStyle = R"css(
td .few { display: block; color: var(--quiet); }
)css";

std::string canonical_paragraph(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + html_escaped(text)) + "\n";
}

bool has_value(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const CanonicalRow& row) { return value_of(row, measure).has_value(); });
}

// Why no trial has a value of the measure.
std::string no_value_text(const std::vector<CanonicalRow>& rows) {
  return has_value(rows, CanonicalMeasure::kShareWithin30deg)
             ? "no trial has a force into the hand, so that there is no ratio"
             : "no trial touched the wall without a fault and within its ends, so that there is "
               "nothing to draw";
}

// Draws the panels of the report.
class CanonicalFigures {
 public:
  CanonicalFigures(const std::vector<CanonicalRow>& rows, std::vector<std::string>& warnings)
      : rows_(rows), warnings_(warnings) {}

  std::string figure(CanonicalMeasure measure, const std::string& id, const std::string& name,
                     const std::string& caption) {
    if (!has_value(rows_, measure)) return missing(no_value_text(rows_));
    // Each panel may append a warning: one after the other.
    const std::string pressed =
        panel(measure, CanonicalMotion::kPressed, id + "-pressed-", name + ", pressed");
    const std::string stroked =
        panel(measure, CanonicalMotion::kStroked, id + "-stroked-", name + ", stroked");
    return "<figure class=\"" + id + "\">\n<div class=\"panels\">\n" + pressed + stroked +
           "</div>\n" + html_element("figcaption", html_escaped(caption)) + "\n</figure>\n";
  }

 private:
  std::string panel(CanonicalMeasure measure, CanonicalMotion motion, const std::string& id,
                    const std::string& name) {
    const auto svg = canonical_svg(rows_, measure, motion);
    if (svg) return inline_svg(*svg, id, name);
    return missing(name + ": is not drawn: " + svg.error().to_string());
  }
  // What stands in place of figures; one warning for each reason.
  std::string missing(const std::string& reason) {
    if (std::find(warnings_.begin(), warnings_.end(), reason) == warnings_.end()) {
      warnings_.push_back(reason);
    }
    return html_element("p class=\"bad\"", html_escaped(reason)) + "\n";
  }

  const std::vector<CanonicalRow>& rows_;
  std::vector<std::string>& warnings_;
};

// HTML. The number of operators with a value stands below a mean of some of them.
std::string mean_html(const MeanInterval& interval, int operators) {
  if (interval.count == 0) return "-";
  std::string text = with_decimals(interval.mean, kShownDecimals);
  const std::string half_width = with_decimals(interval.half_width, kShownDecimals);
  const bool is_shown = interval.count > 1 && half_width != with_decimals(0.0, kShownDecimals);
  if (is_shown) text += " \u00b1 " + half_width;
  if (interval.count == operators) return text;
  return text + " " + html_element("span class=\"few\"", "n = " + std::to_string(interval.count));
}

std::string tangent_text(double angle_deg) {
  if (angle_deg >= 90.0) return "-";
  return with_decimals(std::tan(angle_deg * std::numbers::pi / 180.0), kShownDecimals);
}

// One row an angle; without and with rotation.
std::string means_of_motion(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure,
                            CanonicalMotion motion, int operators) {
  const bool is_ratio = measure == CanonicalMeasure::kAlongOverInto;
  std::vector<std::string> heads{"angle (deg)"};
  if (is_ratio) heads.emplace_back("tan\u00a0a");
  heads.insert(heads.end(), {"NoR", "R"});
  HtmlTable table(heads);
  const auto without = canonical_means(rows, measure, motion, false);
  const auto with = canonical_means(rows, measure, motion, true);
  for (std::size_t i = 0; i < without.size() && i < with.size(); ++i) {
    const double angle_deg = without[i].cell.angle_deg;
    std::vector<std::string> cells{as_printed(angle_deg)};
    if (is_ratio) cells.push_back(tangent_text(angle_deg));
    cells.push_back(mean_html(without[i].interval, operators));
    cells.push_back(mean_html(with[i].interval, operators));
    table.row(cells);
  }
  return table.html();
}

// One table for each motion, below each other on a narrow screen.
std::string means_tables(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure,
                         int operators) {
  return "<div class=\"panels\">\n<div><h3>Pressed</h3>\n" +
         means_of_motion(rows, measure, CanonicalMotion::kPressed, operators) +
         "</div>\n<div><h3>Stroked</h3>\n" +
         means_of_motion(rows, measure, CanonicalMotion::kStroked, operators) + "</div>\n</div>\n";
}

// Explains the ratios that are missing although there was contact.
std::string missing_ratios_html(const std::vector<CanonicalRow>& rows) {
  bool is_across = false, is_elsewhere = false;
  for (const CanonicalRow& row : rows) {
    if (row.along_over_into || !row.share_within_30deg) continue;
    (row.cell.angle_deg == 90.0 && !row.cell.rotates ? is_across : is_elsewhere) = true;
  }
  std::string out;
  if (is_across) {
    out +=
        canonical_paragraph("Why is there no ratio at 90 deg without rotation?",
                            "The motor then lies along the wall and is not used: there is no force "
                            "into the hand to divide by.");
  }
  if (is_elsewhere) {
    out += canonical_paragraph(
        is_across ? "Why is there no ratio elsewhere?" : "Why is there no ratio?",
        "The trials touch the wall without a force into the hand to divide by, as at a wall "
        "without stiffness.");
  }
  return out;
}

std::string canonical_reading_html(const std::vector<CanonicalRow>& rows) {
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
         missing_ratios_html(rows) +
         canonical_paragraph(
             "Whiskers, \u00b1 and n",
             "95 % intervals of the mean over simulated operators (Student\u2019s "
             "t). More operators make them shorter; they say nothing about people. The whiskers "
             "stand beside their point; \u00b1 0.000 is left out. n is the number of operators "
             "with a value, where some have none; - stands where none has.") +
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

std::string ratio_section_html(const std::vector<CanonicalRow>& rows, int operators,
                               CanonicalFigures& figures) {
  std::string caption =
      "Mean part of the commanded force along the wall, divided by its mean part along the "
      "wall\u2019s normal, over the angle of the wall at the start. Dashed: tan\u00a0a.";
  const bool is_cut = is_canonical_ratio_cut(rows, CanonicalMotion::kPressed) ||
                      is_canonical_ratio_cut(rows, CanonicalMotion::kStroked);
  if (is_cut) caption += " NoR and tan\u00a0a go on above the figure; the table has all values.";
  const std::string figure = figures.figure(CanonicalMeasure::kAlongOverInto, "ratio",
                                            "Force along over force into", caption);
  return "<section id=\"ratio\">\n<h2>Force along the wall over force into the hand</h2>\n" +
         figure + means_tables(rows, CanonicalMeasure::kAlongOverInto, operators) + "</section>\n";
}

std::string share_section_html(const std::vector<CanonicalRow>& rows, int operators,
                               CanonicalFigures& figures) {
  const std::string figure = figures.figure(
      CanonicalMeasure::kShareWithin30deg, "share", "Share within 30 deg",
      "Share of the contact in which the angle between the wall\u2019s normal and the motor is at "
      "most 30 deg.");
  return "<section id=\"share\">\n<h2>Share of the contact within 30 deg</h2>\n" + figure +
         means_tables(rows, CanonicalMeasure::kShareWithin30deg, operators) + "</section>\n";
}

}  // namespace

std::string canonical_report_html(const std::vector<CanonicalRow>& rows,
                                  const CanonicalFacts& facts, std::vector<std::string>& warnings) {
  const std::string title = "The canonical wall, with simulated operators";
  CanonicalFigures figures(rows, warnings);
  const std::string header =
      "<header>\n" + html_element("h1", html_escaped(title)) + "\n" +
      html_element("p",
                   "A flat wall at an angle to the only motor, pressed and stroked by simulated "
                   "operators, without rotation (NoR) and with A4 (R).") +
      "\n</header>\n";
  const std::string ratio = ratio_section_html(rows, facts.participants, figures);
  const std::string share = share_section_html(rows, facts.participants, figures);
  const std::string body = header + "<main>\n" + ratio + share + canonical_reading_html(rows) +
                           canonical_facts_html(rows, facts) + "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kCanonicalStyle), body);
}

}  // namespace palpate
