#pragma once

// The report of an experiment: one page for readers, tables for programs, and lines for the
// terminal.

#include <string>
#include <vector>

#include "engine/analysis/analysis.h"
#include "engine/analysis/analysis_tables.h"
#include "engine/report/output_files.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// An HTML5 document (UTF-8) that needs no other file, no network and no script. It lists what
// agrees with the paper and what does not, then shows the figures and all statistics of each
// following beside those of the paper, and then explains how to read them. Appends to `warnings` if
// figures could not be drawn.
std::string experiment_report_html(const ExperimentAnalysis& analysis, const TrialSource& source,
                                   std::vector<std::string>& warnings);

// A few lines for a terminal: what was analysed, and the verdicts of the first following.
std::string experiment_text(const ExperimentAnalysis& analysis);

// The names of the files that write_experiment_report() writes.
std::vector<std::string> experiment_report_names();

// Writes report.html, analysis.json and a CSV file for each of kAnalysisTableNames. files: created
// with the names of experiment_report_names(). Returns the warnings.
Result<std::vector<std::string>> write_experiment_report(const ExperimentAnalysis& analysis,
                                                         const TrialSource& source,
                                                         const OutputFiles& files);

struct AnalysedTrials {
  ExperimentAnalysis analysis;
  OutputFiles files;  // complete, but not in place: call move_into_place()
  std::string text;   // for the terminal, with the place of the report
  std::vector<std::string> warnings;
};

// Analyses the rows of a file and writes the report for a folder. If it returns an error, no file
// is changed.
//
// Errors: those of analyse_trials() and of writing; rows with a strategy; and a completed trial
// that is longer than the time limit, if the file has timeouts.
Result<AnalysedTrials> report_trials(std::vector<TrialRow> rows, const TrialSource& source,
                                     const std::string& folder);

}  // namespace palpate
