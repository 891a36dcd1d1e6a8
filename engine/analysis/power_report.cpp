#include "engine/analysis/power_report.h"

#include <cmath>
#include <set>
#include <utility>

#include "engine/analysis/power_fit.h"
#include "engine/analysis/power_notes.h"
#include "engine/analysis/power_plots.h"
#include "engine/analysis/power_tables.h"
#include "engine/analysis/power_text.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/report_style.h"
#include "engine/report/text_file.h"

namespace palpate {
namespace {

constexpr const char* kPowerPage = "report.html";
constexpr const char* kPowerJson = "power.json";
// Not "people.csv": people give their pilots such names.
constexpr const char* kPeopleTable = "needed_people.csv";

// Added to the style of all reports.
constexpr std::string_view kPowerStyle = R"css(
.advice .wide { background: #fff; border: 1px solid var(--line); border-radius: 6px; }
.advice ul { margin: .2rem 0; padding-left: 1.2rem; }
details > summary { cursor: pointer; color: #0057a3; margin: .8rem 0; }
h4 { font-size: .95rem; margin: 1rem 0 .2rem; }
.power td, .power .interval, .power .spread { white-space: nowrap; }
.power td.verdict { min-width: 0; white-space: normal; }
@media (max-width: 800px) {
  .power td.number { white-space: normal; }
  .power .interval { font-size: .8em; letter-spacing: -.02em; }
  #answer { padding: .1rem .5rem .6rem; }
}
)css";

std::string power_note(const std::string& text) {
  return html_element("p class=\"note\"", html_escaped(text)) + "\n";
}

// The interval of a power, in parentheses, stays on one line of a narrow screen.
std::string power_cell(const std::string& text) {
  const std::size_t interval = text.find('(');
  if (interval == std::string::npos) return html_escaped(text);
  return html_escaped(text.substr(0, interval)) +
         html_element("span class=\"interval\"", html_escaped(text.substr(interval)));
}

std::string answer_table(const PowerStudy& study) {
  std::vector<std::string> heads = {"test"};
  for (const int percent : kPowerPercents) {
    heads.push_back("people for a power of 0." + std::to_string(percent / 10));
  }
  heads.push_back("power with " + std::to_string(power_example(study)) + " people");
  HtmlTable table(heads);
  for (const PowerLine& line : power_lines(study)) {
    std::vector<std::string> cells = {html_escaped(line.test)};
    for (const std::string& people : line.people) cells.push_back(power_cell(people));
    cells.push_back(power_cell(line.power));
    table.row(cells);
  }
  return table.html();
}

std::string power_answer_html(const PowerStudy& study) {
  std::string items;
  for (const std::string& note : power_notes(study)) {
    items += html_element("li", html_escaped(note)) + "\n";
  }
  const std::string range =
      study.has_one_noise()
          ? "In parentheses: the numbers at which the bounds of the simulation's 95 % interval "
            "reach "
            "the power. "
          : "A range is over all assumptions about the variances: its first number is of the "
            "kindest one. ";
  return "<section class=\"advice power\" id=\"answer\">\n<h2>How many people</h2>\n" +
         answer_table(study) +
         power_note(range +
                    "The smallest number from which on the power does not fall below 0.8 or 0.9. " +
                    ">" + std::to_string(study.settings().participants) +
                    ": more than were simulated. no effect: the assumed means make the test's "
                    "hypothesis true, so that its power is its rate of false alarms.") +
         "<ul>\n" + items + "</ul>\n</section>\n";
}

std::string power_figures_html(const PowerStudy& study, std::vector<std::string>& warnings) {
  const auto panels = power_panels(study);
  if (!panels) {
    warnings.push_back("the report has no figures: " + panels.error().to_string());
    return "";
  }
  std::string out;
  for (std::size_t i = 0; i < panels->size(); ++i) {
    const PowerPanel& panel = (*panels)[i];
    out += inline_svg(panel.svg, "p" + std::to_string(i) + "-", "power of " + panel.title);
  }
  const auto drawn = drawn_assumptions(study);
  std::string caption =
      "Power over the number of people. Bands: 95 % interval (Wilson) of the simulated share; "
      "dotted lines: 0.8 and 0.9.";
  if (drawn.size() == 2) {
    caption += " The panels of pairs have the assumption with the most noise.";
  } else if (drawn.size() > 2) {
    caption += " Three of the " + std::to_string(study.assumptions.size()) +
               " assumptions: with the least, a middle and the most noise. The panels of pairs "
               "have the middle one: " +
               assumption_text(study, drawn[1]) + ".";
  }
  return "<section id=\"figures\">\n<h2>Power over the number of people</h2>\n<figure>\n"
         "<div class=\"panels\">\n" +
         out + "</div>\n" + html_element("figcaption", html_escaped(caption)) +
         "\n</figure>\n</section>\n";
}

// The smallest numbers for one test and one source of the error: w downwards, u to the right.
std::string grid_table(const PowerStudy& study, std::size_t test, const std::string& error_from) {
  std::set<double> us, ws;
  for (const PowerAssumption& assumed : study.assumptions) {
    us.insert(assumed.share_u);
    ws.insert(assumed.share_w);
  }
  std::vector<std::string> heads = {"share of w"};
  for (const double u : us) heads.push_back("u " + number_or_dash(u));
  HtmlTable table(heads);
  for (const double w : ws) {
    std::vector<std::string> cells = {number_or_dash(w)};
    for (const double u : us) {
      cells.emplace_back();
      for (std::size_t i = 0; i < study.assumptions.size(); ++i) {
        const PowerAssumption& assumed = study.assumptions[i];
        if (assumed.error_from != error_from || assumed.share_u != u || assumed.share_w != w) {
          continue;
        }
        cells.back() =
            html_escaped(people_text(study, i, test, kPowerPercents[0])) + " " +
            html_element("span class=\"spread\"",
                         "/ " + html_escaped(people_text(study, i, test, kPowerPercents[1])));
      }
    }
    table.row(cells);
  }
  return table.html();
}

std::string grids_html(const PowerStudy& study) {
  if (study.assumptions.size() == 1) return "";
  std::set<std::string> sources;
  for (const PowerAssumption& assumed : study.assumptions) sources.insert(assumed.error_from);
  const auto lines = power_lines(study);
  std::string out =
      "<section class=\"power\" id=\"grid\">\n<h2>By the shares of u and w</h2>\n" +
      power_note(
          "The smallest number of people for a power of 0.8 / 0.9, by the shares of u and w "
          "in the variance of one trial. The rest is e.");
  for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
    if (study.tests.is_null(study.tests.tests[t], study.model.means)) continue;
    out += "<details>\n" + html_element("summary", html_escaped(lines[t].test)) + "\n";
    for (const std::string& from : sources) {
      out += html_element("h4", "Error: " + html_escaped(from)) + "\n" + grid_table(study, t, from);
    }
    out += "</details>\n";
  }
  return out + "</section>\n";
}

std::string pilot_pairs_html(const PowerStudy& study) {
  HtmlTable table({"pair", "sd in the pilot", "sd in the model"});
  for (const PilotPair& pair : pilot_fit(*study.pilot, study.tests).pairs) {
    table.row({html_escaped(pair.pair), number_or_dash(pair.observed), number_or_dash(pair.model)});
  }
  return table.html() +
         power_note(
             "The standard deviation over people of the difference between their means. If the "
             "pilot's are smaller than the model's, or unlike each other, the model does not fit.");
}

std::string pilot_html(const PowerStudy& study) {
  if (!study.pilot) return "";
  const PilotEstimate& pilot = *study.pilot;
  HtmlTable table({"part", "mean square", "df", "estimate of the variance", "used"});
  table.row({"u, between people", number_or_dash(pilot.ms_p), std::to_string(pilot.df_p),
             number_or_dash(pilot.raw.u), number_or_dash(pilot.variances.u)});
  table.row({"w, people x conditions", number_or_dash(pilot.ms_pc), std::to_string(pilot.df_pc),
             number_or_dash(pilot.raw.w), number_or_dash(pilot.variances.w)});
  table.row({"e, trials", number_or_dash(pilot.ms_e), std::to_string(pilot.df_e),
             number_or_dash(pilot.raw.e), number_or_dash(pilot.variances.e)});
  const std::string k = std::to_string(study.model.design.conditions());
  std::string means;
  for (std::size_t c = 0; c < pilot.means.size(); ++c) {
    means += (c > 0 ? ", " : "") + study.model.design.condition_name(c) + " " +
             number_or_dash(pilot.means[c]);
  }
  return "<section class=\"power\" id=\"pilot\">\n<h2>The variances of the pilot</h2>\n" +
         table.html() +
         power_note("e = MS_e, w = (MS_pc - MS_e) / m, u = (MS_p - MS_pc) / (" + k +
                    " m), with m = " + number_or_dash(pilot.m) +
                    " trials of a person in a condition. MS_e leaves out what all people have in "
                    "common in a condition, an object and a block.") +
         power_note("Means of the pilot: " + means +
                    ". They are not the assumed effects: with so few people they are too uncertain "
                    "to plan by.") +
         pilot_pairs_html(study) + "</section>\n";
}

std::string power_facts_html(const PowerStudy& study) {
  std::string out = "<section id=\"facts\">\n<h2>What was computed</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : power_facts(study)) {
    out += html_element("dt", html_escaped(name)) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n" +
         power_note(
             "Each data set goes through the primary analysis of `palpate experiment "
             "analyse`: repeated measures, uncorrected and by Greenhouse and Geisser, and "
             "paired t tests by Holm, at 5 %. The first n people of a data set are those "
             "of its point n, so that a curve is smooth; its points are not independent. "
             "An interval states the error of the simulation, and not that of the "
             "assumptions.") +
         "</section>\n";
}

}  // namespace

std::string power_report_html(const PowerStudy& study, std::vector<std::string>& warnings) {
  const std::string title =
      "How many people: " + std::string(outcome_text(study.measure->outcome).name);
  const std::string out = "<header>\n" + html_element("h1", html_escaped(title)) +
                          "\n</header>\n<main>\n" + power_answer_html(study) +
                          power_figures_html(study, warnings) + grids_html(study) +
                          pilot_html(study) + power_facts_html(study) + "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kPowerStyle), out);
}

std::vector<std::string> power_report_names() {
  return {kPowerPage, kPowerJson, kPeopleTable, "power.csv"};
}

Result<std::vector<std::string>> write_power_report(const PowerStudy& study,
                                                    const OutputFiles& files) {
  std::vector<std::string> warnings;
  const std::pair<std::string, std::string> texts[] = {
      {kPowerPage, power_report_html(study, warnings)},
      {kPowerJson, power_json(study)},
      {kPeopleTable, csv_of(power_people_table(study))},
      {"power.csv", csv_of(power_curve_table(study))}};
  for (const auto& [name, text] : texts) {
    const auto written = write_text_file(files.path(name), text);
    if (!written) return files.in_place(written.error());
  }
  return warnings;
}

}  // namespace palpate
