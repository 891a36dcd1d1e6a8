#include "engine/accuracy/accuracy_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "engine/report/html.h"
#include "engine/report/human_units.h"
#include "engine/report/report_style.h"

namespace palpate {
namespace {

// Elements

std::string cell(const std::string& content) {
  return html_element("td", content);
}
std::string number_cell(const std::string& content) {
  return html_element("td class=\"number\"", content);
}

// A text of the caller as the end of a sentence.
std::string sentence(const std::string& text) {
  const bool ends =
      !text.empty() && std::string_view(".!?").find(text.back()) != std::string_view::npos;
  return html_escaped(text) + (ends ? "" : ".");
}

// A text of the caller as a sentence of its own.
std::string whole_sentence(std::string text) {
  if (text.empty()) return "";
  if (text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return sentence(text);
}

std::string paragraph(const std::string& label, const std::string& text) {
  if (text.empty()) return "";
  return html_element("p", html_element("strong", label + ":") + " " + text) + "\n";
}

// The id of a heading that links refer to.
std::string anchor_of(std::size_t chapter) {
  return "knob-" + std::to_string(chapter + 1);
}

// Numbers

std::string error_text(const Knob& knob, double error) {
  return html_escaped(human(error, knob.error.unit));
}
// An error at the floor is at most the floor.
std::string error_text(const Knob& knob, const LevelResult& level) {
  return (level.at_floor ? "\u2264 " : "") + error_text(knob, level.error.median);
}
std::string time_text(const Knob& knob, double time) {
  return html_escaped(human(time, knob.time.unit));
}

// Median and quartiles, all in the unit of the median.
std::string spread_text(const Spread& spread, const std::string& unit) {
  const DisplayUnit shown = display_unit(spread.median, unit);
  const auto number = [&](double value) { return short_number(value * shown.factor); };
  std::string text = html_escaped(human(spread.median, unit));
  if (spread.low == spread.high) return text;
  return text + " <span class=\"spread\">[" + number(spread.low) + ", " + number(spread.high) +
         "]</span>";
}

// By how much something is worse, with two digits.
std::string factor_text(double factor) {
  if (!std::isfinite(factor)) return "without bound";
  const double percent = std::round(100.0 * (factor - 1.0));
  if (percent < 1.0) return "less than 1 %";
  if (percent < 100.0) return short_number(percent) + " %";
  const double digit = std::pow(10.0, std::floor(std::log10(factor)) - 1.0);
  return short_number(std::round(factor / digit) * digit) + " times";
}

const LevelResult& level_at(const KnobResult& result, const LevelPlace& place) {
  return result.methods[place.method].levels[place.level];
}

// A level, with its method if the knob has several.
std::string place_name(const KnobResult& result, const LevelPlace& place) {
  const std::string& level = level_at(result, place).label;
  if (result.methods.size() == 1) return html_escaped(level);
  return html_escaped(result.methods[place.method].name + ", " + level);
}

// Summary

std::string order_summary(const KnobResult& result) {
  std::string text;
  for (const MethodResult& method : result.methods) {
    if (!method.order && !method.expected_order) continue;
    if (!text.empty()) text += "<br>";
    if (result.methods.size() > 1) text += html_escaped(method.name) + ": ";
    text += method.order ? order_number(*method.order) : "not fitted";
    if (method.expected_order) text += "&nbsp;/&nbsp;" + short_number(*method.expected_order);
  }
  return text.empty() ? "-" : text;
}

std::string verdict_summary(const KnobResult& result) {
  if (!result.has_choice()) return "no choice";
  if (result.default_is_on_front()) return html_element("span class=\"good\"", "on the front");
  return html_element("span class=\"bad\"", factor_text(result.default_behind) + " behind " +
                                                html_escaped(result.better_than_default)) +
         "<br>" + html_escaped(result.knob.default_because);
}

std::string preset_summary(const KnobResult& result, const LevelResult& preset) {
  if (!preset.counts()) return html_element("span class=\"bad\"", "failed");
  return error_text(result.knob, preset) + "<br>" + time_text(result.knob, preset.time.median);
}

// The verdicts come first, so that they fit a narrow screen.
std::string summary_row(const KnobResult& result, std::size_t chapter) {
  const auto verdict = [](const std::string& content) {
    return html_element("td class=\"verdict\"", content);
  };
  std::string row = "<tr>" +
                    verdict("<a href=\"#" + anchor_of(chapter) + "\">" +
                            html_escaped(result.knob.title) + "</a>") +
                    verdict(!result.has_choice() ? "-"
                            : result.recommended ? place_name(result, *result.recommended)
                                                 : "none") +
                    verdict(verdict_summary(result)) +
                    cell(place_name(result, result.default_place()));
  for (const LevelResult& preset : result.presets) {
    row += number_cell(preset_summary(result, preset));
  }
  return row + html_element("td class=\"order\"", order_summary(result)) + "</tr>\n";
}

std::string summary(const AccuracyReport& report) {
  if (report.chapters.empty()) return "";
  std::string out =
      "<h2 id=\"summary\">Summary of the knobs</h2>\n<div class=\"wide\"><table>\n<thead><tr>"
      "<th>knob</th><th>recommended</th><th>default against the Pareto front</th><th>default</th>";
  for (const char* name : kPresetNames) {
    out += std::string("<th class=\"number\">") + name + "<br>error<br>time</th>";
  }
  out += "<th>order<br>fitted / theory</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < report.chapters.size(); ++i) {
    out += summary_row(report.chapters[i].result, i);
  }
  return out + "</tbody></table></div>\n";
}

// Advice

std::string answer_html(const Answer& answer) {
  return html_element("dt", html_escaped(answer.setting)) +
         html_element("dd", html_element("strong", html_escaped(answer.value)) +
                                html_element("span class=\"reason\"", html_escaped(answer.reason)) +
                                html_element("span class=\"limit\"", html_escaped(answer.limit))) +
         "\n";
}

std::string advice_html(const Advice& advice) {
  std::string out =
      "<section class=\"advice\" id=\"advice\">\n" +
      html_element("h2", html_escaped(advice.subject)) + "\n" +
      html_element("p class=\"note\"", "Device: " + html_escaped(advice.device) + ".") + "\n<dl>\n";
  for (const Answer& answer : advice.answers) out += answer_html(answer);
  // Lines break between words, never at a hyphen.
  std::string command;
  for (const std::string& word : command_words(advice)) {
    command += (command.empty() ? "" : " ") + html_element("span", html_escaped(word));
  }
  return out + "</dl>\n" + html_element("p", "To try these settings with a simulated device:") +
         "\n" + html_element("pre", html_element("code", command)) + "\n</section>\n";
}

// A knob

std::string figure_title(const KnobResult& result, const std::string& against) {
  return result.knob.title + ": " + result.knob.error.name + " against " + against + ", " +
         std::to_string(result.methods.size()) +
         (result.methods.size() == 1 ? " curve" : " curves");
}

bool any_level(const KnobResult& result, bool (*is)(const LevelResult&)) {
  for (const MethodResult& method : result.methods) {
    if (std::any_of(method.levels.begin(), method.levels.end(), is)) return true;
  }
  return false;
}

// Whether the level is in a grey band of the diagrams.
bool has_zero(const LevelResult& level) {
  return level.counts() && (!(level.error.median > 0.0) || !(level.time.median > 0.0));
}
bool is_at_zero(const LevelResult& level) {
  return level.counts() && !(level.value > 0.0);
}

std::string caption(const KnobResult& result) {
  std::string text = "Points are medians, whiskers quartiles. ";
  if (result.knob.levels_are_given && result.knob.methods_are_given) {
    text += "Neither level nor curve is a choice: labels name the curves. ";
  } else if (result.knob.levels_are_given) {
    text += "The level is not a choice: grey rings mark the best curves at each level. ";
  } else if (result.knob.methods_are_given) {
    text += "The curve is not a choice: grey rings mark the Pareto front of each curve. ";
  } else {
    text += "Grey: the Pareto front and its levels. ";
  }
  if (any_level(result, [](const LevelResult& l) { return l.at_floor; })) {
    text += "Open points are at the floor. ";
    if (!any_level(result, [](const LevelResult& l) { return l.counts() && !l.at_floor; })) {
      text += "All levels are: they differ in time alone. ";
    }
  }
  if (!any_level(result, [](const LevelResult& l) { return l.counts() && l.error.median > 0.0; })) {
    text += "No level has an error above 0. ";
  } else if (any_level(result, has_zero) || any_level(result, is_at_zero) ||
             std::any_of(result.presets.begin(), result.presets.end(), has_zero)) {
    text += "A grey band holds values of exactly 0, which a logarithmic axis cannot show. ";
  }
  if (any_level(result, [](const LevelResult& l) { return !l.counts(); })) {
    text += "Failed levels are not drawn; they are listed below. ";
  }
  return text;
}

std::string figure(const KnobChapter& chapter, std::size_t index) {
  if (!chapter.panels) {
    return html_element("p class=\"bad\"",
                        "No diagram: " + html_escaped(chapter.panels.error().to_string())) +
           "\n";
  }
  const std::string prefix = anchor_of(index);
  const KnobResult& result = chapter.result;
  return "<figure class=\"work-precision\">\n<div class=\"panels\">\n" +
         inline_svg(chapter.panels->error_against_time, prefix + "-t-",
                    figure_title(result, result.knob.time.name)) +
         inline_svg(chapter.panels->error_against_level, prefix + "-l-",
                    figure_title(result, result.knob.level.name)) +
         "</div>\n" + html_element("figcaption", caption(result)) + "\n</figure>\n";
}

std::string mark(const char* kind, const char* text) {
  return std::string("<span class=\"mark ") + kind + "\">" + text + "</span>";
}

std::string marks(const KnobResult& result, const LevelPlace& place) {
  const LevelResult& level = level_at(result, place);
  std::string text;
  if (result.recommended == place && result.has_choice()) text += mark("best", "recommended");
  if (place == result.default_place()) text += mark("default", "default");
  if (level.on_front && result.has_choice()) text += mark("front", "front");
  if (level.at_floor) text += mark("floor", "floor");
  if (!level.counts()) {
    text += html_element("span class=\"mark bad\"", std::to_string(level.failures) + " of " +
                                                        std::to_string(level.repeats) + " failed");
  }
  return text;
}

std::string measured_cells(const Knob& knob, const LevelResult& level) {
  if (!level.was_measured()) return number_cell("-") + number_cell("-") + number_cell("-");
  return number_cell((level.at_floor ? "\u2264 " : "") +
                     spread_text(level.error, knob.error.unit)) +
         number_cell(spread_text(level.time, knob.time.unit)) +
         number_cell(short_number(level.iterations));
}

std::string level_row(const KnobResult& result, const LevelPlace& place) {
  const LevelResult& level = level_at(result, place);
  const bool is_recommended = result.recommended == place && result.has_choice();
  return (is_recommended ? "<tr class=\"chosen\">" : "<tr>") +
         html_element("td class=\"verdict\"", html_escaped(level.label)) +
         html_element("td class=\"verdict\"", marks(result, place)) +
         measured_cells(result.knob, level) +
         number_cell(html_escaped(human(level.value, result.knob.level.unit))) + "</tr>\n";
}

// A row across the first two columns, so that the text fits a narrow screen.
std::string method_heading(const std::string& title) {
  return "<tr class=\"method\"><th colspan=\"2\">" + title + "</th><th colspan=\"4\"></th></tr>\n";
}

std::string method_rows(const KnobResult& result, std::size_t m) {
  const MethodResult& method = result.methods[m];
  std::string title = html_escaped(method.name);
  if (method.order) title += ", order " + order_number(*method.order);
  if (method.expected_order) {
    title += std::string(method.order ? " (theory " : ", order not fitted (theory ") +
             short_number(*method.expected_order) + ")";
  }
  if (method.floor > 0.0) title += ", floor " + error_text(result.knob, method.floor);
  std::string rows = method_heading(title);
  for (std::size_t l = 0; l < method.levels.size(); ++l) rows += level_row(result, {m, l});
  return rows;
}

std::string preset_rows(const KnobResult& result) {
  std::string rows = method_heading("presets, at the default");
  for (const LevelResult& preset : result.presets) {
    rows += "<tr>" + html_element("td class=\"verdict\"", html_escaped(preset.label)) +
            html_element("td class=\"verdict\"", preset.counts() ? "" : mark("bad", "failed")) +
            measured_cells(result.knob, preset) + number_cell("") + "</tr>\n";
  }
  return rows;
}

std::string column(const std::string& name, const char* below) {
  return html_element("th class=\"number\"", html_element("span", html_escaped(name)) + below);
}

std::string level_table(const KnobResult& result) {
  const Knob& knob = result.knob;
  constexpr const char* kStatistics = "<br>median [quartiles]";
  std::string out =
      "<h3>Levels</h3>\n<div class=\"wide\"><table>\n<thead><tr><th>level</th>"
      "<th>marks</th>" +
      column(knob.error.name, kStatistics) + column(knob.time.name, kStatistics) +
      column("iterations", "<br>per tick") + column(knob.level.name, "") +
      "</tr></thead>\n<tbody>\n";
  for (std::size_t m = 0; m < result.methods.size(); ++m) out += method_rows(result, m);
  return out + preset_rows(result) + "</tbody></table></div>\n";
}

std::string failure_item(const std::string& name, const LevelResult& level) {
  return html_element("li", html_escaped(name) + ": " + std::to_string(level.failures) + " of " +
                                std::to_string(level.repeats) + " repeats, " +
                                html_escaped(level.failure)) +
         "\n";
}

std::string failures(const KnobResult& result) {
  std::string items;
  for (const MethodResult& method : result.methods) {
    for (const LevelResult& level : method.levels) {
      if (!level.counts()) items += failure_item(method.name + ", " + level.label, level);
    }
  }
  for (const LevelResult& preset : result.presets) {
    if (!preset.counts()) items += failure_item("preset " + preset.label, preset);
  }
  if (items.empty()) return "";
  return "<h3>Failures</h3>\n<ul class=\"failures\">\n" + items + "</ul>\n";
}

// The reason of the recommendation, as a sentence about the level.
std::string recommendation_reason(const KnobResult& result) {
  const Knob& knob = result.knob;
  const LevelResult& level = level_at(result, *result.recommended);
  if (!result.decided_by_title.empty()) {
    return "The knob \"" + html_escaped(result.decided_by_title) +
           "\" decides, because this knob measures only a part of the error.";
  }
  const std::string among = knob.levels_are_given ? " of the methods at this level" : "";
  const bool is_default = *result.recommended == result.default_place();
  const std::string enough = error_text(knob, knob.enough);
  std::string text;
  if (level.error.median > knob.enough) {
    text = "Its error is the smallest" + among + "; none is down to " + enough;
  } else if (is_default) {
    text = "The default: no level" + among + " with an error of at most " + enough +
           " is clearly quicker, or as quick and clearly more accurate";
  } else {
    text = "It is the quickest" + among + " with an error of at most " + enough +
           ", or as quick and more accurate";
  }
  if (knob.enough_because.empty()) return text + ".";
  return text + ": " + sentence(knob.enough_because);
}

std::string recommendation(const KnobResult& result) {
  if (!result.has_choice())
    return paragraph("Recommended", whole_sentence(result.knob.enough_because));
  if (!result.recommended) return paragraph("Recommended", "none: every level failed");
  const LevelResult& level = level_at(result, *result.recommended);
  return paragraph("Recommended", place_name(result, *result.recommended) + " (" +
                                      error_text(result.knob, level) + ", " +
                                      time_text(result.knob, level.time.median) + "). " +
                                      recommendation_reason(result));
}

std::string default_verdict(const KnobResult& result) {
  if (!result.has_choice()) return "";
  std::string text = place_name(result, result.default_place()) + ", ";
  if (result.default_is_on_front()) return paragraph("Default", text + "on the front.");
  text +=
      "not on the front: " + html_escaped(result.better_than_default) +
      " is better in time or error, by " +
      (std::isfinite(result.default_behind) ? factor_text(result.default_behind) : "any factor") +
      ", and worse in neither.";
  if (!result.knob.default_because.empty()) {
    text += " Why it is the default: " + sentence(result.knob.default_because);
  }
  return paragraph("Default", text);
}

std::string chapter_html(const KnobChapter& chapter, std::size_t index) {
  const KnobResult& result = chapter.result;
  const Knob& knob = result.knob;
  return "<section id=\"" + anchor_of(index) + "\">\n" +
         html_element("h2", html_escaped(knob.title)) + "\n" +
         paragraph("Workload", whole_sentence(knob.workload)) +
         paragraph("Errors are against", whole_sentence(knob.reference)) +
         paragraph("Floor", whole_sentence(knob.floor_is)) + figure(chapter, index) +
         recommendation(result) + default_verdict(result) + failures(result) + level_table(result) +
         "</section>\n";
}

std::string facts(const AccuracyReport& report) {
  if (report.facts.empty()) return "";
  std::string out = "<section id=\"facts\">\n<h2>How it was measured</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : report.facts) {
    out += html_element("dt", html_escaped(name)) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n</section>\n";
}

// The words that a reader of one diagram needs.
std::string words() {
  constexpr std::pair<const char*, const char*> kWords[] = {
      {"tick", "One cycle of the haptic thread, by default a thousandth of a second."},
      {"proxy",
       "The point that stays on the surface while the device is inside it. A spring K and a damper "
       "B pull the device to it; their force is rendered."},
      {"knob, level",
       "A parameter, and one of its values. Lines connect the levels of one method."},
      {"order",
       "The exponent by which the error falls with the level: with order 2, half the level leaves "
       "a "
       "quarter of the error. The fitted order is given beside that of theory."},
      {"floor",
       "The rounding of the number format. Errors below it are reported as the floor, with "
       "\u2264."},
      {"Pareto front",
       "The levels for which no other level is clearly better in error or time and clearly worse "
       "in "
       "neither."},
      {"recommended",
       "The quickest level whose error is small enough for a hand; each knob states how small, and "
       "why. Levels that do not differ beyond their spread are ties, and the default wins a tie."},
      {"spread",
       "The quartiles over the repeats. Two levels differ if their quartiles do not overlap and "
       "their medians differ by more than 15 %."},
      {"presets",
       "<code>--accuracy fast</code>, <code>balanced</code> and <code>exact</code>, at the default "
       "level. They set the number of proxy iterations and whether the path is certified; where "
       "neither matters they differ by clock noise only."},
      {"rms", "Root mean square."}};
  std::string out = "<h2 id=\"words\">How to read it</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, meaning] : kWords) {
    out += html_element("dt", name) + html_element("dd", meaning) + "\n";
  }
  return out + "</dl>\n";
}

}  // namespace

std::string report_html(const AccuracyReport& report) {
  std::string out =
      "<header>\n" + html_element("h1", html_escaped(report.title)) + "\n</header>\n<main>\n";
  if (report.advice) out += advice_html(*report.advice);
  if (!report.introduction.empty())
    out += html_element("p", html_escaped(report.introduction)) + "\n";
  for (const ReportSection& section : report.sections) {
    out += "<section>\n" + html_element("h2", html_escaped(section.title)) + "\n" + section.html +
           "\n</section>\n";
  }
  out += summary(report);
  if (!report.chapters.empty()) out += words();
  for (std::size_t i = 0; i < report.chapters.size(); ++i) {
    out += chapter_html(report.chapters[i], i);
  }
  return html_page(report.title, kReportStyle, out + facts(report) + "</main>\n");
}

std::vector<KnobChapter> chapters_of(std::span<const KnobResult> results) {
  std::vector<KnobChapter> chapters;
  for (const KnobResult& result : results) {
    chapters.push_back({result, work_precision_panels(result)});
  }
  return chapters;
}

}  // namespace palpate
