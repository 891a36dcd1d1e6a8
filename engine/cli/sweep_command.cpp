#include "engine/cli/sweep_command.h"

#include <utility>

#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/placed_results.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_progress.h"
#include "engine/trials/sweep/sweep_merge.h"
#include "engine/trials/sweep/sweep_run.h"
#include "engine/trials/trial.h"

namespace palpate {
namespace {

constexpr const char* kPoint = "point";

// What was complete before, for the user.
std::string kept_text(const SweepOutcome& outcome, const std::string& folder) {
  const std::string there = folder + "/parts from an earlier run of this sweep\n";
  std::string text;
  if (!outcome.kept.empty()) {
    text = "kept " + count_text(outcome.kept.size(), kPoint) + ", complete in " + there;
  }
  if (outcome.kept_trials > 0) {
    text += outcome.kept.empty()
                ? "kept " + count_text(outcome.kept_trials, "trial") + " in " + there
                : "kept " + kept_trials_text(outcome.kept_trials, kPoint) + " from there\n";
  }
  return text;
}

}  // namespace

void add_sweep(CLI::App& experiment, SweepRequest& request) {
  CLI::App& app = *experiment.add_subcommand(
      "sweep", "repeat the experiment with other assumptions about the hand");
  set_help(app,
           "  ./run.sh experiment plan sweep --out sweep.json    # then edit it\n"
           "  ./run.sh experiment sweep sweep.json --out sweep\n",
           "report.html has a figure for each parameter, varied alone, and the table \"what must "
           "be true of the\nhand\" over a Latin hypercube of all parameters; sweep.csv has the "
           "means that both follow from.\nThey appear when all points are complete; the "
           "sweep that ships takes less than ten minutes\non two cores. If the command is "
           "interrupted or killed, the same command computes the missing\ntrials only. Results of "
           "another sweep in DIR are replaced.\n");
  app.add_option("SWEEP", request.sweep, "sweep, a JSON file; `sweep` is the one that ships")
      ->required();
  app.add_option("--out", request.out_dir, "folder of the results")->capture_default_str();
  app.add_option("--shard", request.shard,
                 "i/n: compute the points i, i + n, i + 2 n, ... only; `experiment merge` joins "
                 "the shards")
      ->type_name("i/n");
  add_integer(app, "--jobs", request.jobs, {1, kMostJobs},
              "points to compute at the same time [the number of cores; 1 for a shard]");
}

int run_sweep_command(const SweepRequest& request) {
  const auto settings = dealt_settings(request.out_dir, request.shard, request.jobs);
  if (!settings) return refuse(settings.error());
  const auto sweep = load_sweep(request.sweep);
  if (!sweep) return refuse(sweep.error());
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto outcome = [&] {
    ProgressBar bar("sweep");
    return run_sweep(*sweep, *settings, {find_trial_way, run_trial}, shown_in(bar), &signal_flag());
  }();
  if (!outcome) return refuse(outcome.error());
  const std::string& folder = settings->out_folder;
  return finish_dealt_run(*outcome, *settings, kept_text(*outcome, folder), kPoint, "sweep",
                          [&]() -> Result<PlacedResults> {
                            auto merged = merge_sweep({folder}, folder);
                            if (!merged) return merged.error();
                            return place_results(std::move(*merged), folder);
                          });
}

}  // namespace palpate
