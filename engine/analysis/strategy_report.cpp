#include "engine/analysis/strategy_report.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/analysis/strategy_tables.h"
#include "engine/analysis/strategy_text.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/report_style.h"
#include "engine/report/text_file.h"
#include "engine/trials/plan_device.h"

namespace palpate {
namespace {

constexpr const char* kComparisonPage = "report.html";
constexpr const char* kComparisonJson = "comparison.json";
const std::string kPlusMinus = "\u00b1";

// Added to the style of all reports.
constexpr std::string_view kComparisonStyle = R"css(
.advice .wide { background: #fff; border: 1px solid var(--line); border-radius: 6px; }
.advice ul { margin: .2rem 0; padding-left: 1.2rem; }
details > summary { cursor: pointer; color: #0057a3; margin: .8rem 0; }
h4 { font-size: .95rem; margin: 1rem 0 .2rem; }
.comparison td { white-space: nowrap; }
.comparison td:first-child { white-space: normal; min-width: 8.5em; }
.comparison th, .comparison td { padding: .25rem .45rem; }
td strong.best { color: var(--good); }
@media (max-width: 800px) { .comparison td:first-child { min-width: 6em; } }
)css";

std::string report_heading(const std::string& title) {
  return html_element("h3", html_escaped(title)) + "\n";
}
std::string report_note(const std::string& text) {
  return html_element("p class=\"note\"", html_escaped(text)) + "\n";
}

const MeasureComparison& first_measure(const SceneComparison& scene) {
  return scene.measures.front();
}

// "E = 0.25"
std::string level_head(const std::string& strategy) {
  return "E = " + strategy.substr(strategy.find(':') + 1);
}

std::vector<std::string> heads_of(const SceneComparison& scene) {
  std::vector<std::string> heads{"measure"};
  for (const StrategyEntry& entry : first_measure(scene).entries) {
    heads.push_back(entry.role == StrategyRole::kLevel ? level_head(entry.strategy)
                                                       : entry.strategy);
  }
  return heads;
}

std::string mean_cell(const MeasureComparison& comparison, const StrategyEntry& entry) {
  const ComparedMeasure& measure = *comparison.measure;
  std::string text =
      html_escaped(shown_interval(measure, entry.mean, shown_decimals(comparison), kPlusMinus));
  if (!comparison.is_tie_of_all()) {
    if (entry.standing == Standing::kBest) text = html_element("strong class=\"best\"", text);
    if (entry.standing == Standing::kTied) text += " =";
  }
  if (!entry.tuned_to.empty()) {
    text += html_element("span class=\"spread\"", "<br>" + level_head(entry.tuned_to));
  }
  return text;
}

// Bold if the interval does not hold 0; green if the strategy is better, red if it is worse.
std::string difference_cell(const MeasureComparison& comparison,
                            const std::optional<MeanInterval>& difference) {
  if (!difference) return "-";
  const std::string text = html_escaped(
      shown_interval(*comparison.measure, *difference, shown_decimals(comparison), kPlusMinus));
  if (!difference->excludes_zero()) return text;
  return html_element(std::string("strong class=\"") +
                          (is_better_difference(difference->mean) ? "good" : "bad") + "\"",
                      text);
}

template <typename Cell>
std::string measures_table(const SceneComparison& scene, const Cell& cell) {
  HtmlTable table(heads_of(scene));
  for (const MeasureComparison& comparison : scene.measures) {
    std::vector<std::string> cells{html_escaped(measure_heading(*comparison.measure))};
    for (const StrategyEntry& entry : comparison.entries) cells.push_back(cell(comparison, entry));
    table.row(cells);
  }
  return table.html();
}

bool is_compared(const SceneComparison& scene, const std::string& name) {
  const auto& entries = first_measure(scene).entries;
  return std::any_of(entries.begin(), entries.end(),
                     [&](const StrategyEntry& entry) { return entry.strategy == name; });
}

std::string difference_table(const SceneComparison& scene, const std::string& other,
                             std::optional<MeanInterval> StrategyEntry::*difference) {
  if (!is_compared(scene, other)) return "";
  return html_element("h4", "Paired difference to <code>" + other + "</code>") + "\n" +
         report_note("Bold: the interval does not hold 0. Green is better, red is worse.") +
         measures_table(scene, [&](const MeasureComparison& comparison, const StrategyEntry& e) {
           return difference_cell(comparison, e.*difference);
         });
}

std::string scene_tables(const SceneComparison& scene) {
  return html_element("h4", "Mean over hands " + kPlusMinus + " 95 % interval") + "\n" +
         report_note(
             "Green: the best technique. =: tied with it. No mark: all techniques are tied.") +
         measures_table(scene, mean_cell) +
         difference_table(scene, "mask", &StrategyEntry::minus_mask) +
         difference_table(scene, "a4", &StrategyEntry::minus_a4);
}

std::string leaders_table(const SceneComparison& scene) {
  HtmlTable table({"measure", "best technique"}, 2);
  for (const MeasureComparison& comparison : scene.measures) {
    table.row({html_escaped(measure_heading(*comparison.measure)),
               html_escaped(leaders_text(comparison))});
  }
  return table.html();
}

std::string losses_html(const FollowingComparison& following) {
  if (!is_compared(following.scenes.front(), "a4")) return "";
  std::string out = report_heading("Where A4 loses");
  const auto losses = losses_by_strategy(following, kPlusMinus);
  if (losses.empty()) return out + html_element("p", "By no measure.") + "\n";
  std::string items;
  for (const LossesToStrategy& to : losses) {
    std::string measures;
    for (const std::string& text : to.measures) measures += (measures.empty() ? "" : "; ") + text;
    items +=
        html_element("li", "to <code>" + html_escaped(to.strategy) + "</code>" +
                               (to.role == StrategyRole::kReference ? " (a reference): " : ": ") +
                               html_escaped(measures)) +
        "\n";
  }
  return out + "<ul>\n" + items + "</ul>\n" +
         report_note("Each number is the paired difference to a4 with half of its 95 % interval.");
}

std::string incomplete_html(const FollowingComparison& following) {
  std::string out;
  for (const std::string& name : following.incomplete()) {
    out += html_element("p class=\"bad\"",
                        "Not comparable: fewer than 90 % of the trials of <code>" +
                            html_escaped(name) + "</code> ended at the red sphere.") +
           "\n";
  }
  return out;
}

std::string answer_html(const FollowingComparison& following) {
  return "<section class=\"advice\" id=\"answer\">\n<h2>Which technique is best, and where A4 "
         "loses</h2>\n" +
         incomplete_html(following) + report_heading("Best technique by each measure") +
         leaders_table(following.scenes.front()) +
         report_note(
             "Techniques are tied if the 95 % interval of their paired difference holds 0. none "
             "and full are references and not ranked: they need no motor, or all of them.") +
         losses_html(following) + html_element("p", html_escaped(kSimulatedHandsSentence)) +
         "\n</section>\n";
}

std::string outcomes_table(const FollowingComparison& following) {
  HtmlTable table({"strategy", "trials", "completed", "timeouts", "faults"});
  for (const StrategyOutcome& outcome : following.outcomes) {
    const StrategyCounts& counts = outcome.counts;
    table.row({html_escaped(outcome.strategy), std::to_string(counts.trials),
               std::to_string(counts.done), std::to_string(counts.timeouts),
               std::to_string(counts.faults)});
  }
  return table.html();
}

// The levels of one scene, or of all together, on the hands that tune.
std::string tuning_table(const FollowingComparison& following, const std::string& scene,
                         std::size_t levels) {
  std::vector<std::string> heads{"measure"};
  for (std::size_t i = 0; i < levels; ++i) {
    heads.push_back(level_head(following.tuning[i].strategy));
  }
  HtmlTable table(heads);
  for (std::size_t first = 0; first < following.tuning.size(); first += levels) {
    if (following.tuning[first].scene != scene) continue;
    const ComparedMeasure& measure = *following.tuning[first].measure;
    MeasureComparison row{&measure, {}};  // for the number of decimals
    for (std::size_t i = 0; i < levels; ++i) {
      row.entries.push_back({});
      row.entries.back().mean = following.tuning[first + i].mean;
    }
    std::vector<std::string> cells{html_escaped(measure_heading(measure))};
    for (std::size_t i = 0; i < levels; ++i) {
      const TuningEntry& entry = following.tuning[first + i];
      const std::string text =
          html_escaped(shown_interval(measure, entry.mean, shown_decimals(row), kPlusMinus));
      cells.push_back(entry.is_chosen ? html_element("strong class=\"best\"", text) : text);
    }
    table.row(cells);
  }
  return table.html();
}

std::size_t level_count(const FollowingComparison& following) {
  return static_cast<std::size_t>(
      std::count_if(following.outcomes.begin(), following.outcomes.end(),
                    [](const StrategyOutcome& o) { return o.role == StrategyRole::kLevel; }));
}

std::string tuning_html(const FollowingComparison& following) {
  if (following.tuning.empty()) return "";
  return report_heading("The tuning of anisotropic") +
         report_note(
             "Means on hands with other seeds than those compared. The value of E that is best by "
             "a measure (bold) is used on the compared hands for this measure. All values of E are "
             "also columns of the tables above, where they are not ranked.") +
         tuning_table(following, "", level_count(following));
}

std::string following_html(const FollowingComparison& following) {
  std::string out = "<section class=\"comparison\" id=\"" + following.following + "\">\n" +
                    html_element("h2", "Simulated hands, " + html_escaped(following.following)) +
                    "\n" + report_heading("All scenes together") +
                    scene_tables(following.scenes.front()) + tuning_html(following) +
                    report_heading("How the trials ended") + outcomes_table(following);
  for (std::size_t i = 1; i < following.scenes.size(); ++i) {
    const SceneComparison& scene = following.scenes[i];
    out += "<details>\n" + html_element("summary", "Scene " + html_escaped(scene.scene)) + "\n" +
           leaders_table(scene) + scene_tables(scene);
    if (!following.tuning.empty()) {
      out += html_element("h4", "The tuning of anisotropic") +
             tuning_table(following, scene.scene, level_count(following));
    }
    out += "</details>\n";
  }
  return out + "</section>\n";
}

std::string explanation(const std::string& title, const std::string& text) {
  return html_element("p", html_element("strong", title) + " " + html_escaped(text)) + "\n";
}

std::string comparison_reading_html() {
  return "<section id=\"reading\">\n<h2>How to read this</h2>\n" +
         explanation("What do the intervals mean?",
                     kSimulatedHandsSentence +
                         " More hands make any difference significant. The intervals are not "
                         "corrected for the number of comparisons: of twenty differences that are "
                         "0, one is expected to look like one.") +
         explanation("What is paired?",
                     "All strategies meet the same hands with the same random numbers on the same "
                     "scenes. A hand counts with the mean of its differences on the scenes that it "
                     "completed with both strategies; the interval is Student\u2019s t over "
                     "hands.") +
         explanation("What is better?",
                     "Lower, for all measures but two: of the missing force and of the work lost, "
                     "the magnitudes are compared, so that nearer to 0 is better. Port work and "
                     "work of one contact are work on the hand: a device that gives less is the "
                     "calmer one.") +
         explanation("Trials that were not completed",
                     "are left out of all measures but timeouts. A strategy that completes fewer "
                     "than 90 % of its trials is not comparable: its means are those of the easier "
                     "trials.") +
         explanation("Drift",
                     "is the distance of the scene from its place at the start. If the scene "
                     "turned, the distance has no meaning, and the table has a dash.") +
         explanation("What is left out?",
                     "Visual springs, sound and vibration render a force that the motors cannot: "
                     "force and pose are those of mask, and a simulated hand perceives neither "
                     "picture nor sound, so a comparison would say nothing. The virtual haptic "
                     "sphere needs torques.") +
         "</section>\n";
}

std::string settings_html(const CompareSettings& settings) {
  std::string scenes;
  for (const std::string& scene : settings.scenes) scenes += (scenes.empty() ? "" : ", ") + scene;
  std::vector<std::pair<std::string, std::string>> facts = {
      {"Scenes", scenes},
      {"Hands", std::to_string(settings.hands) + " of " + settings.person},
      {"Seed", std::to_string(settings.seed)}};
  if (settings.is_tuned) {
    facts.emplace_back("Seed of the tuning",
                       std::to_string(compare_seed(settings.seed, CompareHands::kTuning)));
  }
  const auto device = plan_device_json(settings.device);
  for (const auto& [key, value] : device.items()) facts.emplace_back(key, value.dump());
  std::string out = "<section id=\"facts\">\n<h2>What was compared</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    out += html_element("dt", html_escaped(name)) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n</section>\n";
}

}  // namespace

std::string comparison_html(const CompareSettings& settings,
                            const std::vector<FollowingComparison>& followings) {
  const std::string title = "Techniques for missing motors, on simulated hands";
  std::string out =
      "<header>\n" + html_element("h1", html_escaped(title)) + "\n" +
      html_element("p", "Each technique on the same " + std::to_string(settings.hands) +
                            " simulated hands and the same scenes.") +
      "\n</header>\n<main>\n" + answer_html(followings.front());
  for (const FollowingComparison& following : followings) out += following_html(following);
  out += comparison_reading_html() + settings_html(settings) + "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kComparisonStyle), out);
}

std::vector<std::string> comparison_report_names() {
  std::vector<std::string> names = {kComparisonPage, kComparisonJson};
  for (const std::string_view name : kStrategyTableNames) {
    names.push_back(std::string(name) + ".csv");
  }
  return names;
}

std::optional<Error> write_comparison_report(const CompareSettings& settings,
                                             const std::vector<FollowingComparison>& followings,
                                             const OutputFiles& files) {
  std::vector<std::pair<std::string, std::string>> texts = {
      {kComparisonPage, comparison_html(settings, followings)},
      {kComparisonJson, comparison_json(settings, followings)}};
  for (const ResultTable& table : strategy_tables(followings)) {
    texts.emplace_back(table.name + ".csv", csv_of(table));
  }
  for (const auto& [name, text] : texts) {
    const auto written = write_text_file(files.path(name), text);
    if (!written) return files.in_place(written.error());
  }
  return std::nullopt;
}

}  // namespace palpate
