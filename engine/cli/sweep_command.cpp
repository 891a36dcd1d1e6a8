#include "engine/cli/sweep_command.h"

#include <functional>
#include <iostream>
#include <sstream>
#include <utility>

#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_progress.h"
#include "engine/trials/sweep/sweep_run.h"
#include "engine/trials/trial.h"

namespace palpate {
namespace {

constexpr const char* kPoint = "point";

struct WholeSweep : SweepOutcome {
  std::optional<MergedSweep> merged;  // no value: a shard, or stopped
};

Result<WholeSweep> run_whole_sweep(const Sweep& sweep, const DealtSettings& settings,
                                   const std::function<void(const RunProgress&)>& show) {
  auto done = run_sweep(sweep, settings, {find_trial_way, run_trial}, show, &signal_flag());
  if (!done) return done.error();
  WholeSweep outcome{std::move(*done), std::nullopt};
  if (settings.shard || !outcome.not_done.empty()) return outcome;
  auto merged = merge_sweep({settings.out_folder}, settings.out_folder);
  if (!merged) return merged.error();
  outcome.merged = std::move(*merged);
  return outcome;
}

std::string outcome_text(const WholeSweep& outcome, const DealtSettings& settings) {
  const std::string& folder = settings.out_folder;
  std::string text;
  if (!outcome.kept.empty()) {
    text += "kept " + count_text(outcome.kept.size(), kPoint) + ", complete in " + folder +
            "/parts from an earlier run of this sweep\n";
  }
  if (outcome.kept_trials > 0) {
    text += outcome.kept.empty()
                ? "kept " + count_text(outcome.kept_trials, "trial") + " in " + folder +
                      "/parts from an earlier run of this sweep\n"
                : "kept " + kept_trials_text(outcome.kept_trials, kPoint) + " from there\n";
  }
  return text + (outcome.merged ? merged_text(*outcome.merged, folder)
                                : shard_text(outcome, settings, kPoint, "sweep"));
}

}  // namespace

std::string merged_text(const MergedSweep& merged, const std::string& folder) {
  std::ostringstream text;
  text << count_text(static_cast<std::size_t>(merged.points), kPoint) << ", " << merged.trials
       << " trials: " << merged.done << " done, " << merged.timeouts << " timeout, "
       << merged.faults << " fault\n"
       << merged.text << "report.html, sweep.csv and the tables are in " << folder << "/\n";
  return text.str();
}

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
    return run_whole_sweep(*sweep, *settings, shown_in(bar));
  }();
  if (!outcome) return refuse(outcome.error());
  if (!outcome->not_done.empty()) return report_interruption(*outcome, kPoint, request.out_dir);
  std::cout << outcome_text(*outcome, *settings);
  return exit_code_after_signals(
      finish_output(outcome->merged ? outcome->merged->warnings : std::vector<std::string>()));
}

}  // namespace palpate
