#include "engine/cli/placed_results.h"

#include <iostream>
#include <sstream>
#include <utility>

#include "engine/cli/command_output.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/python_page.h"
#include "engine/cli/run_progress.h"
#include "engine/trials/deal/result_names.h"

namespace palpate {
namespace {

// files: what is in the folder with the page.
Result<PlacedResults> placed(OutputFiles& files, RunKind kind, const std::string& folder,
                             const std::string& counts, const std::string& all_files) {
  const std::string command(words_of(kind).name);
  const auto outcome =
      place_with_page({command, "--", files.hidden_folder()}, page_names(kind), files);
  if (!outcome) return outcome.error();
  if (outcome->end == PageEnd::kInterrupted) return PlacedResults{true, {}, {}};
  const std::string there = outcome->end == PageEnd::kMade
                                ? all_files
                                : command + ".csv, " + kColumnsFile + " and " + kRunFile;
  return PlacedResults{false, counts + "\n" + outcome->text + there + " are in " + folder + "/\n",
                       with_page_warnings({}, *outcome)};
}

}  // namespace

Result<PlacedResults> place_results(MergedSweep merged, const std::string& folder) {
  std::ostringstream counts;
  counts << count_text(static_cast<std::size_t>(merged.points), "point") << ", " << merged.trials
         << " trials: " << merged.done << " done, " << merged.timeouts << " timeout, "
         << merged.faults << " fault";
  auto results = placed(merged.files, RunKind::kSweep, folder, counts.str(),
                        "report.html, sweep.csv and the tables");
  if (results && merged.done == 0) {
    results->warnings.insert(results->warnings.begin(),
                             "no trial ended at the red sphere, so that no ranking is testable");
  }
  return results;
}

Result<PlacedResults> place_results(MergedCanonical merged, const std::string& folder) {
  std::ostringstream counts;
  counts << merged.trials << " trials of " << merged.participants
         << (merged.participants == 1 ? " participant" : " participants")
         << " at the canonical wall";
  if (merged.without_result > 0) counts << ", " << merged.without_result << " without a result";
  return placed(merged.files, RunKind::kCanonical, folder, counts.str(),
                "canonical.csv, columns.csv, canonical.html and run.json");
}

int finish_dealt_run(const DealtOutcome& outcome, const DealtSettings& settings,
                     const std::string& kept, const std::string& noun,
                     const std::string& merged_dir,
                     const std::function<Result<PlacedResults>()>& place) {
  const auto interrupted = [&] { return report_interruption(outcome, noun, settings.out_folder); };
  if (!outcome.not_done.empty()) return interrupted();
  if (settings.shard) {
    std::cout << kept << shard_text(outcome, settings, noun, merged_dir);
    return exit_code_after_signals(finish_output());
  }
  const auto results = place();
  if (!results) return refuse(results.error());
  if (results->is_interrupted) return interrupted();
  std::cout << kept << results->text;
  return exit_code_after_signals(finish_output(results->warnings));
}

}  // namespace palpate
