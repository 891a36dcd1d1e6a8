#include "engine/analysis/experiment_report.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/analysis/report_differences.h"
#include "engine/analysis/report_explanations.h"
#include "engine/analysis/report_operator.h"
#include "engine/analysis/report_verdicts.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/html.h"
#include "engine/report/report_style.h"
#include "engine/report/text_file.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr const char* kPage = "report.html";
constexpr const char* kJson = "analysis.json";

// Added to the style of all reports.
constexpr std::string_view kExperimentStyle = R"css(
.advice h3 { margin: .6rem 0 .2rem; }
.advice ul { margin: .2rem 0; padding-left: 1.2rem; }
.advice .wide { background: #fff; border: 1px solid var(--line); border-radius: 6px; }
.lists { display: grid; grid-template-columns: repeat(auto-fit, minmax(16rem, 1fr)); gap: 0 2rem; }
h4 { font-size: .95rem; margin: 1rem 0 .2rem; }
td.finding { min-width: 11em; }
td.found { min-width: 10em; }
.mark.untested { color: var(--quiet); }
.mark.flips { color: #7a4f00; }
.figure7 .panels { align-items: center; }
details > summary { cursor: pointer; color: #0057a3; margin: .8rem 0; }
.operator td { white-space: nowrap; }
.operator td:first-child { white-space: normal; min-width: 10em; }
tr.groups th { border-bottom: 0; text-align: center; color: var(--quiet); }
.operator th, .operator td { padding: .25rem .45rem; }
.operator th.number { min-width: 3.6em; }
@media (max-width: 800px) {
  tr.groups th { text-align: left; }
  .operator td:first-child { min-width: 6em; }
  td.finding { min-width: 9em; }
  td.found { min-width: 8.5em; }
}
)css";

std::string who(const ExperimentAnalysis& analysis) {
  if (!analysis.has_simulated()) return "people";
  return analysis.has_people() ? "people and simulated operators" : "simulated operators";
}

std::string title_of(const ExperimentAnalysis& analysis) {
  if (!analysis.has_simulated()) return "The paper\u2019s experiment: analysis of trials";
  return "The paper\u2019s experiment with " + who(analysis);
}

int trials_in_file(const OperatorAnalysis& analysis) {
  return analysis.counts.done + analysis.counts.timeouts + analysis.counts.faults;
}

// "57: 40 timeouts, 0 faults, 17 absent"; "none"
std::string missing_text(const ExperimentAnalysis& analysis) {
  int timeouts = 0, faults = 0, absent = 0;
  for (const OperatorAnalysis& each : analysis.operators) {
    timeouts += each.counts.timeouts;
    faults += each.counts.faults;
    absent += each.counts.absent;
  }
  if (timeouts + faults + absent == 0) return "none";
  const auto counted = [](int n, const char* one, const char* many) {
    return std::to_string(n) + " " + (n == 1 ? one : many);
  };
  return std::to_string(timeouts + faults + absent) + " (" +
         counted(timeouts, "timeout", "timeouts") + ", " + counted(faults, "fault", "faults") +
         ", " + std::to_string(absent) + " absent)";
}

// "delayed, predict"; "delayed; delayed, start 45 deg"
std::string names_of(const ExperimentAnalysis& analysis) {
  std::string text;
  const char* const between = analysis.variants() > 1 ? "; " : ", ";
  constexpr std::size_t kMostNames = 8;
  const std::size_t count = analysis.operators.size();
  for (std::size_t i = 0; i < std::min(count, kMostNames); ++i) {
    text += (text.empty() ? "" : between) + analysis.operators[i].name();
  }
  if (count > kMostNames) text += " and " + std::to_string(count - kMostNames) + " more";
  return text;
}

std::size_t most_participants(const ExperimentAnalysis& analysis) {
  std::size_t most = 0;
  for (const OperatorAnalysis& each : analysis.operators) {
    most = std::max(most, each.table.participants().size());
  }
  return most;
}

int all_trials(const ExperimentAnalysis& analysis) {
  int trials = 0;
  for (const OperatorAnalysis& each : analysis.operators) trials += trials_in_file(each);
  return trials;
}

std::string facts_html(const ExperimentAnalysis& analysis, const TrialSource& source) {
  const TrialTable& table = analysis.operators[0].table;
  const std::pair<std::string, std::string> facts[] = {
      {"File", source.file},
      {"Trials", std::to_string(all_trials(analysis)) + " (practice is left out)"},
      {"Missing trials", missing_text(analysis)},
      {analysis.has_simulated() ? "Operators" : "Participants",
       std::to_string(most_participants(analysis))},
      {analysis.variants() > 1 ? "Followings and settings" : "Followings",
       analysis.has_simulated() || analysis.variants() > 1 ? names_of(analysis) : ""},
      {"Blocks", std::to_string(table.level_count(kTrialFactor))},
      {"Time limit", number_or_dash(source.limit_s) + " s"}};
  std::string out = "<section id=\"facts\">\n<h2>What was analysed</h2>\n<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    if (value.empty()) continue;
    out += html_element("dt", name) + html_element("dd", html_escaped(value)) + "\n";
  }
  return out + "</dl>\n</section>\n";
}

// The limit is wrong if a completed trial is longer, and matters if the file has timeouts.
std::optional<Error> check_limit(const std::vector<TrialRow>& rows, double limit_s) {
  const bool has_timeouts = std::any_of(rows.begin(), rows.end(), [](const TrialRow& row) {
    return row.block > 0 && row.status == TrialStatus::kTimeout;
  });
  for (const TrialRow& row : rows) {
    const double time_s = row.measures[kTotalTime].value_or(0.0);
    if (!has_timeouts || row.block == 0 || row.status != TrialStatus::kDone) continue;
    if (!(time_s > limit_s)) continue;
    return invalid_argument("participant " + printable(row.participant) + ", block " +
                                std::to_string(row.block) + ", " + row.haptic + ", " +
                                row.rotation + ", " + printable(row.object) + ", total_time_s",
                            "is " + number_or_dash(time_s) +
                                " in a completed trial; expected at most the time limit, " +
                                number_or_dash(limit_s) + " s, because the file has timeouts",
                            "give the time limit of the trials with --limit");
  }
  return std::nullopt;
}

// The analysis is of Haptic and Rotation.
std::optional<Error> check_factors(const std::vector<TrialRow>& rows) {
  for (const TrialRow& row : rows) {
    if (row.strategy.empty()) continue;
    return Error{ErrorCode::kInvalidContent, "", "column strategy",
                 "is " + row.strategy + " in a trial of participant " + printable(row.participant) +
                     "; expected trials with haptic and rotation",
                 "`palpate compare` compares strategies"};
  }
  return std::nullopt;
}

Error of_file(Error error, const std::string& file) {
  if (error.path.empty()) error.path = file;
  return error;
}

}  // namespace

std::string experiment_report_html(const ExperimentAnalysis& analysis, const TrialSource& source,
                                   std::vector<std::string>& warnings) {
  const std::string title = title_of(analysis);
  std::string out = "<header>\n" + html_element("h1", html_escaped(title)) + "\n" + levels_html() +
                    "</header>\n<main>\n" + verdicts_html(analysis);
  for (std::size_t i = 0; i < analysis.operators.size(); ++i) {
    out += operator_html(analysis.operators[i], i == 0, warnings);
  }
  out += differences_html(analysis) + explanations_html(analysis) + facts_html(analysis, source) +
         "</main>\n";
  return html_page(title, std::string(kReportStyle) + std::string(kExperimentStyle), out);
}

std::string experiment_text(const ExperimentAnalysis& analysis) {
  const OperatorAnalysis& leading = analysis.operators[0];
  std::string text = std::to_string(all_trials(analysis)) + " trials of " +
                     std::to_string(most_participants(analysis)) + " " + who(analysis);
  if (analysis.has_simulated()) text += " (" + names_of(analysis) + ")";
  text += "; missing: " + missing_text(analysis) + "\n";
  text += "the paper's " + std::to_string(paper_findings().size()) + " findings, " +
          leading.name() + ": " + verdict_counts_text(leading) + "\n";
  for (const Verdict verdict : {Verdict::kAgrees, Verdict::kDisagrees, Verdict::kNotTestable}) {
    std::string label(kVerdictNames[static_cast<std::size_t>(verdict)]);
    label.resize(14, ' ');
    for (const auto& [name, statement] : findings_with(leading, verdict)) {
      text += "  " + label + name + ": " + statement + "\n";
    }
  }
  if (const auto flips = differing_findings(analysis); !flips.empty()) {
    text += std::to_string(flips.size()) +
            (flips.size() == 1 ? " verdict flips" : " verdicts flip") + std::string(" between ") +
            columns_text(analysis) + "\n";
  }
  return text;
}

std::vector<std::string> experiment_report_names() {
  std::vector<std::string> names = {kPage, kJson};
  for (const std::string_view name : kAnalysisTableNames) {
    names.push_back(std::string(name) + ".csv");
  }
  return names;
}

Result<std::vector<std::string>> write_experiment_report(const ExperimentAnalysis& analysis,
                                                         const TrialSource& source,
                                                         const OutputFiles& files) {
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> texts = {
      {kPage, experiment_report_html(analysis, source, warnings)},
      {kJson, analysis_json(analysis, source)}};
  for (const ResultTable& table : analysis_tables(analysis)) {
    texts.emplace_back(table.name + ".csv", csv_of(table));
  }
  for (const auto& [name, text] : texts) {
    const auto written = write_text_file(files.path(name), text);
    if (!written) return files.in_place(written.error());
  }
  return warnings;
}

Result<AnalysedTrials> report_trials(std::vector<TrialRow> rows, const TrialSource& source,
                                     const std::string& folder) {
  if (const auto error = check_factors(rows)) return of_file(*error, source.file);
  if (const auto error = check_limit(rows, source.limit_s)) return of_file(*error, source.file);
  auto analysis = analyse_trials(std::move(rows), source.limit_s);
  if (!analysis) return of_file(analysis.error(), source.file);
  auto files = OutputFiles::create(folder, experiment_report_names());
  if (!files) return files.error();
  auto warnings = write_experiment_report(*analysis, source, *files);
  if (!warnings) return warnings.error();
  std::string text = experiment_text(*analysis);
  text += "report.html, analysis.json and " + std::to_string(kAnalysisTableNames.size()) +
          " tables are in " + folder + "/\n";
  return AnalysedTrials{std::move(*analysis), std::move(*files), std::move(text),
                        std::move(*warnings)};
}

}  // namespace palpate
