#include "engine/cli/sweep_command.h"

#include <algorithm>
#include <iostream>
#include <sstream>

#include "engine/cli/command_help.h"
#include "engine/cli/command_line.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_progress.h"
#include "engine/cli/shard_option.h"
#include "engine/experiment/trial.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

// "1 point", "12 points"
std::string points_text(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " point" : " points");
}

std::string outcome_text(const SweepOutcome& outcome, const SweepRequest& request) {
  std::string text;
  if (!outcome.kept.empty()) {
    text += "kept " + points_text(outcome.kept.size()) + ", complete in " + request.out_dir +
            "/parts from an earlier run of this sweep\n";
  }
  if (outcome.merged) return text + merged_text(*outcome.merged, request.out_dir);
  if (outcome.computed.empty() && outcome.kept.empty()) {
    return text + "shard " + request.shard + " has no point\n";
  }
  return text + "shard " + request.shard + " is complete in " + request.out_dir +
         "/parts\nmerge all shards: " +
         shell_line({"experiment", "merge", request.out_dir, "...", "--out", "sweep"}) + "\n";
}

int report_interrupted_sweep(const SweepOutcome& outcome, const SweepRequest& request) {
  const std::size_t done = outcome.computed.size() + outcome.kept.size();
  std::cerr << "palpate: interrupted; " << done << " of "
            << points_text(done + outcome.not_done.size()) << " are complete in " << request.out_dir
            << "/parts, and the same command goes on from there\n";
  return exit_code_after_signals(0);
}

Result<DealtSettings> settings_of(const SweepRequest& request) {
  DealtSettings settings;
  settings.out_folder = request.out_dir;
  if (!request.shard.empty()) {
    const auto shard = parse_shard(request.shard);
    if (!shard) return shard.error();
    settings.shard = *shard;
  }
  const int cores = static_cast<int>(std::min<std::size_t>(core_count(), kMostJobs));
  settings.jobs = request.jobs.value_or(settings.shard ? 1 : cores);
  return settings;
}

}  // namespace

std::string merged_text(const MergedSweep& merged, const std::string& folder) {
  std::ostringstream text;
  text << points_text(static_cast<std::size_t>(merged.points)) << ", " << merged.trials
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
           "interrupted or killed, the same command computes the missing\npoints only. Results of "
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
  const auto settings = settings_of(request);
  if (!settings) return refuse(settings.error());
  const auto sweep = load_sweep(request.sweep);
  if (!sweep) return refuse(sweep.error());
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto outcome = [&] {
    ProgressBar bar("sweep");
    return run_sweep(*sweep, *settings, {find_trial_way, run_trial}, shown_in(bar, "sweep"),
                     &signal_flag());
  }();
  if (!outcome) return refuse(outcome.error());
  if (!outcome->not_done.empty()) return report_interrupted_sweep(*outcome, request);
  std::cout << outcome_text(*outcome, request);
  return exit_code_after_signals(
      finish_output(outcome->merged ? outcome->merged->warnings : std::vector<std::string>()));
}

}  // namespace palpate
