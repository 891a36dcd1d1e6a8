// `experiment`: runs the paper's experiment with simulated operators, and analyses its trials.

#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_line.h"
#include "engine/cli/command_output.h"
#include "engine/cli/experiment_export.h"
#include "engine/cli/experiment_forget.h"
#include "engine/cli/experiment_live.h"
#include "engine/cli/experiment_power.h"
#include "engine/cli/number_option.h"
#include "engine/cli/placed_results.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/python_page.h"
#include "engine/cli/run_progress.h"
#include "engine/cli/sweep_command.h"
#include "engine/report/output_files.h"
#include "engine/report/whole_file.h"
#include "engine/trials/as_printed.h"
#include "engine/trials/canonical/canonical_plan.h"
#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/canonical/canonical_run.h"
#include "engine/trials/deal/dealt_merge.h"
#include "engine/trials/deal/experiment_merge.h"
#include "engine/trials/deal/experiment_run.h"
#include "engine/trials/deal/result_names.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/plan.h"
#include "engine/trials/shipped_files.h"
#include "engine/trials/trial.h"
#include "engine/trials/trials_file.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// "1, 2 and 5"
std::string number_list(const std::vector<int>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += i + 1 < numbers.size() ? ", " : " and ";
    text += std::to_string(numbers[i]);
  }
  return text;
}

// "participant 3", "participants 1 and 2"
std::string participants_text(const std::vector<int>& numbers) {
  return (numbers.size() == 1 ? "participant " : "participants ") + number_list(numbers);
}

std::string merged_text(const MergedExperiment& merged, const std::string& folder) {
  std::ostringstream text;
  text << merged.trials << " trials of " << merged.participants
       << (merged.participants == 1 ? " participant:" : " participants:");
  for (std::size_t i = 0; i < kSimulatedStatusCount; ++i) {
    text << (i > 0 ? ", " : " ") << merged.by_status[i] << " " << kTrialStatusNames[i];
  }
  text << "\ntrials.csv, columns.csv and run.json are in " << folder << "/\n";
  return text.str();
}

// Options of one subcommand. Each has a function that adds them and one that runs.

struct ExperimentRunRequest {
  std::string plan;
  std::string out_dir = "experiment";
  std::string shard;
  std::optional<int> jobs;
  bool traces = false;
};

constexpr const char* kParticipant = "participant";

// What was complete before, for the user.
std::string kept_text(const DealtOutcome& outcome, const std::string& folder) {
  const std::string there = folder + "/parts from an earlier run of this plan\n";
  std::string text;
  if (!outcome.kept.empty()) {
    text = "kept " + participants_text(outcome.kept) + ", complete in " + there;
  }
  if (outcome.kept_trials > 0) {
    text += outcome.kept.empty()
                ? "kept " + count_text(outcome.kept_trials, "trial") + " in " + there
                : "kept " + kept_trials_text(outcome.kept_trials, kParticipant) + " from there\n";
  }
  return text;
}

int run_canonical_plan(const CanonicalPlan& plan, const DealtSettings& settings,
                       bool writes_traces) {
  if (writes_traces) {
    return refuse(invalid_argument("--traces", "is given with a canonical plan; expected no traces",
                                   "leave it out"));
  }
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto outcome = [&] {
    ProgressBar bar("experiment");
    return run_canonical(plan, settings, shown_in(bar), &signal_flag());
  }();
  if (!outcome) return refuse(outcome.error());
  const std::string& folder = settings.out_folder;
  return finish_dealt_run(*outcome, settings, kept_text(*outcome, folder), kParticipant,
                          "experiment", [&]() -> Result<PlacedResults> {
                            auto merged = merge_canonical({folder}, folder);
                            if (!merged) return merged.error();
                            return place_results(std::move(*merged), folder);
                          });
}

int run_experiment_plan(const ExperimentPlan& plan, const DealtSettings& settings,
                        bool writes_traces) {
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto outcome = [&] {
    ProgressBar bar("experiment");
    return run_experiment(plan, {settings.out_folder, settings.shard, settings.jobs, writes_traces},
                          {find_trial_way, run_trial}, shown_in(bar), &signal_flag());
  }();
  if (!outcome) return refuse(outcome.error());
  const std::string& folder = settings.out_folder;
  if (!outcome->not_done.empty()) return report_interruption(*outcome, kParticipant, folder);
  std::cout << kept_text(*outcome, folder)
            << (outcome->merged ? merged_text(*outcome->merged, folder)
                                : shard_text(*outcome, settings, kParticipant, "experiment"));
  std::vector<std::string> warnings = plan.warnings();
  for (const std::string& warning : outcome->scene_warnings) warnings.push_back(warning);
  return exit_code_after_signals(finish_output(warnings));
}

int run_plan(const ExperimentRunRequest& request) {
  std::error_code failed;
  if (fs::exists(fs::path(request.out_dir) / "participants", failed)) {
    return refuse({ErrorCode::kFileUnwritable, request.out_dir, "",
                   "has trials of people (`experiment live`); expected another folder",
                   "choose one with --out"});
  }
  const auto settings = dealt_settings(request.out_dir, request.shard, request.jobs);
  if (!settings) return refuse(settings.error());
  const auto canonical = load_canonical_plan(request.plan);
  if (!canonical) return refuse(canonical.error());
  if (*canonical) return run_canonical_plan(**canonical, *settings, request.traces);
  const auto plan = load_plan(request.plan);
  if (!plan) return refuse(plan.error());
  return run_experiment_plan(*plan, *settings, request.traces);
}

void add_run(CLI::App& experiment, ExperimentRunRequest& request) {
  CLI::App& app = *experiment.add_subcommand("run", "run all trials of a plan");
  set_help(
      app,
      "  ./run.sh experiment plan paper --out plan.json    # then edit it\n"
      "  ./run.sh experiment run plan.json --out experiment\n",
      "Each trial is kept in DIR/parts when it ends. If the command is interrupted or killed, the "
      "same\ncommand computes the missing trials only. trials.csv, columns.csv and run.json "
      "appear when all\nparticipants are complete; run.log has the times of computing.\nResults of "
      "another plan in DIR stay until the new results replace them; trials of another plan "
      "that are\nin no results yet are not replaced: the command is refused.\n\n"
      "A plan with \"protocol\": \"canonical\" has a wall in place of objects: "
      "canonical.csv and canonical.html\nappear in place of trials.csv.\n");
  app.add_option("PLAN", request.plan,
                 "plan, a JSON file; `paper` and `canonical` are the plans that ship")
      ->required();
  app.add_option("--out", request.out_dir, "folder of the results")->capture_default_str();
  app.add_option("--shard", request.shard,
                 "i/n: compute the participants i, i + n, i + 2 n, ... only; `experiment merge` "
                 "joins the shards")
      ->type_name("i/n");
  add_integer(app, "--jobs", request.jobs, {1, kMostJobs},
              "participants to compute at the same time [the number of cores; 1 for a shard]");
  app.add_flag("--traces", request.traces,
               "write every tick of every trial to DIR/traces, about 0.5 MB a simulated second");
}

struct ExperimentPlanRequest {
  std::string name;
  std::string out_path;
};

int write_plan(const ExperimentPlanRequest& request) {
  const bool is_canonical = request.name == kCanonicalPlan;
  const bool is_sweep = request.name == kShippedSweep;
  if (!is_shipped_plan(request.name) && !is_canonical && !is_sweep) {
    return refuse(invalid_argument(
        "NAME", "is \"" + request.name + "\"; expected paper, paper-live, paper-live-mouse, " +
                    std::string(kCanonicalPlan) + " or " + std::string(kShippedSweep)));
  }
  const std::string path = request.out_path.empty() ? request.name + ".json" : request.out_path;
  std::error_code failed;
  if (fs::exists(fs::symlink_status(path, failed))) {
    return refuse({ErrorCode::kFileUnwritable, path, "",
                   "exists already, and may have been edited; expected a new file",
                   "choose another name with --out, or remove the file"});
  }
  const std::string folder = fs::path(path).parent_path().string();
  const auto text = is_canonical ? Result<std::string>(std::string(shipped_canonical()))
                    : is_sweep   ? shipped_sweep_for(folder)
                                 : shipped_plan_for(request.name, folder);
  if (!text) return refuse(text.error());
  auto file = WholeFile::create(path);
  if (!file) return refuse(file.error());
  file->add(*text);
  if (const auto error = file->finish()) return refuse(*error);
  std::cout << path << "\nrun it: " << shell_line({"experiment", is_sweep ? "sweep" : "run", path})
            << "\n";
  return finish_output();
}

void add_plan(CLI::App& experiment, ExperimentPlanRequest& request) {
  CLI::App& app =
      *experiment.add_subcommand("plan", "write a plan that ships, to edit it or to read it");
  set_help(app,
           "  ./run.sh experiment plan paper --out plan.json\n"
           "  ./run.sh experiment plan canonical --out wall.json\n"
           "  ./run.sh experiment plan sweep --out sweep.json\n",
           "The paths of the objects in the plan lead from the plan's folder to the models.\n");
  app.add_option("NAME", request.name,
                 "paper: the paper's experiment; paper-live and paper-live-mouse: the same for "
                 "people, with "
                 "a board or a mouse; canonical: a wall at an angle to the motor; sweep: "
                 "other assumptions about the hand")
      ->required();
  app.add_option("--out", request.out_path, "file to write; it must not exist [NAME.json]");
}

struct ExperimentMergeRequest {
  std::vector<std::string> folders;
  std::string out_dir = "experiment";
};

template <typename Merged>
Result<PlacedResults> place_merged(Result<Merged> merged, const std::string& out) {
  if (!merged) return merged.error();
  return place_results(std::move(*merged), out);
}

// Joins the parts of any kind of run.
Result<PlacedResults> merge_folders(const std::vector<std::string>& folders,
                                    const std::string& out) {
  const auto kind = kind_of_run_in(folders.front());
  if (!kind) return kind.error();
  if (*kind == RunKind::kCanonical) return place_merged(merge_canonical(folders, out), out);
  if (*kind == RunKind::kSweep) return place_merged(merge_sweep(folders, out), out);
  const auto merged = merge_experiment(folders, out);
  if (!merged) return merged.error();
  return PlacedResults{false, merged_text(*merged, out), {}};
}

int merge(const ExperimentMergeRequest& request) {
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  const auto results = merge_folders(request.folders, request.out_dir);
  if (!results) return refuse(results.error());
  if (results->is_interrupted) {
    std::cerr << "palpate: interrupted; nothing is written\n";
    return exit_code_after_signals(0);
  }
  std::cout << results->text;
  return exit_code_after_signals(finish_output(results->warnings));
}

void add_merge(CLI::App& experiment, ExperimentMergeRequest& request) {
  CLI::App& app =
      *experiment.add_subcommand("merge", "join the shards of an experiment or of a sweep");
  set_help(app,
           "  ./run.sh experiment plan paper --out plan.json\n"
           "  ./run.sh experiment run plan.json --shard 1/2 --out shard-1\n"
           "  ./run.sh experiment run plan.json --shard 2/2 --out shard-2\n"
           "  ./run.sh experiment merge shard-1 shard-2 --out experiment\n",
           "A participant, or a point of a sweep, may be in several shards, if its results are "
           "equal.\n");
  app.add_option("DIR", request.folders, "folders of `experiment run --out` or `experiment sweep`")
      ->required();
  app.add_option("--out", request.out_dir, "folder of the results; it may be one of DIR")
      ->capture_default_str();
}

struct ExperimentAnalyseRequest {
  std::string file;
  double limit_s = 120.0;
  std::string out_dir = "analysis";
};

constexpr std::array kAnalysisNames = {
    "report.html",        "analysis.json", "effects.csv",     "comparisons.csv", "means.csv",
    "missing_trials.csv", "findings.csv",  "verdicts.csv",    "variances.csv",   "loss_rates.csv",
    "differences.csv",    "ratings.csv",   "rating_tests.csv"};

// An error if there is no such file, or if it has other results than trials. The file becomes an
// input, which no output replaces.
std::optional<Error> check_trials_file(const std::string& file) {
  const auto start = read_regular_file(file, kMostTrialsBytes, 1);
  if (start) return check_not_canonical(file);
  Error error = start.error();
  std::error_code failed;
  const fs::path folder = file;
  if (fs::is_directory(folder, failed)) {
    error.hint = results_in(folder.string(), RunKind::kCanonical).empty()
                     ? "name the file of trials in it, such as " + (folder / kTrialsFile).string()
                     : (folder / kCanonicalPage).string() + " has the analysis of this run";
  }
  return error;
}

int analyse(const ExperimentAnalyseRequest& request) {
  if (const auto error = check_trials_file(request.file)) return refuse(*error);
  if (const auto error = check_output()) return refuse(*error);
  // From here on a signal waits until the files are complete.
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  auto files = OutputFiles::create(request.out_dir, {kAnalysisNames.begin(), kAnalysisNames.end()});
  if (!files) return refuse(files.error());
  PageOutcome outcome = make_page(
      {"experiment", "--trials=" + request.file, "--limit=" + as_printed(request.limit_s)}, *files);
  outcome.text += "report.html, analysis.json and 11 tables are in " + request.out_dir + "/\n";
  return finish_page(outcome, *files);
}

void add_analyse(CLI::App& experiment, ExperimentAnalyseRequest& request) {
  CLI::App& app = *experiment.add_subcommand(
      "analyse", "compare trials, of people or simulated, with the paper's results");
  set_help(
      app,
      "  ./run.sh experiment plan paper --out plan.json\n"
      "  ./run.sh experiment run plan.json --out experiment\n"
      "  ./run.sh experiment analyse experiment/trials.csv --out analysis\n",
      "report.html states what agrees with the paper and what does not, with figures and all "
      "statistics.\nanalysis.json has the same numbers for other programs, and effects.csv, "
      "comparisons.csv, means.csv,\nmissing_trials.csv, findings.csv, verdicts.csv, "
      "variances.csv,\nloss_rates.csv, differences.csv, ratings.csv and rating_tests.csv have them "
      "as tables. Trials with several\nlevels of view, align, start orientation or scale are "
      "analysed separately, and compared in\ndifferences.csv. Questionnaires are analysed, too, if "
      "the file questionnaires.csv lies beside TRIALS; its\ncolumns are participant, block, "
      "haptic, rotation, item and value. The answers of\nseveral blocks are averaged.\n\n"
      "A file of people needs the columns participant, block, haptic (NoH, UaH, H; or NoH, "
      "seen-UaH,\nseen-H), rotation (NoR, R), object, status (done, timeout, fault, aborted, "
      "skipped), total_time_s,\nlosses_of_contact and mean_penetration_m or mean_penetration_dm; "
      "mean_contact_angle_deg is optional.\nOf several attempts at a trial the last completed one "
      "counts. Rows with pilot 1 are left out.\n");
  app.add_option("TRIALS", request.file,
                 "file of trials, as `experiment run` writes it (trials.csv)")
      ->required();
  app.add_option("--out", request.out_dir, "folder of the results")->capture_default_str();
  add_real(app, "--limit", request.limit_s, kAboveZero,
           "time limit of a trial, s: the time of a trial with the status timeout");
}

class ExperimentCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override {
    app_ = program.add_subcommand(
        "experiment",
        "run the paper's experiment, or a wall, with simulated operators, and analyse trials");
    app_->require_subcommand(1);
    set_help(*app_, "  ./run.sh experiment plan paper --out plan.json\n",
             "Edit the plan, run it, and compare the trials with the paper's results:\n"
             "  ./run.sh experiment run plan.json --out experiment\n"
             "  ./run.sh experiment analyse experiment/trials.csv\n"
             "The plan of the paper takes about five minutes on two cores.\n\n"
             "A wall at angles to the only motor, pressed and stroked:\n"
             "  ./run.sh experiment run canonical --out wall\n\n"
             "./run.sh experiment COMMAND --help lists the options of a command.\n");
    add_plan(*app_, plan_);
    add_run(*app_, run_);
    add_sweep(*app_, sweep_);
    add_merge(*app_, merge_);
    add_analyse(*app_, analyse_);
    add_power(*app_, power_);
    add_export(*app_, export_);
    add_live(*app_, live_);
    add_forget(*app_, forget_);
    return app_;
  }

  int run(const std::vector<std::string>&) override {
    if (app_->got_subcommand("run")) return run_plan(run_);
    if (app_->got_subcommand("sweep")) return run_sweep_command(sweep_);
    if (app_->got_subcommand("analyse")) return analyse(analyse_);
    if (app_->got_subcommand("plan")) return write_plan(plan_);
    if (app_->got_subcommand("power")) return run_power(power_);
    if (app_->got_subcommand("export")) return run_export(export_);
    if (app_->got_subcommand("live")) return run_live(live_);
    if (app_->got_subcommand("forget")) return run_forget(forget_);
    return merge(merge_);
  }

 private:
  CLI::App* app_ = nullptr;
  ExperimentRunRequest run_;
  SweepRequest sweep_;
  ExperimentAnalyseRequest analyse_;
  ExperimentPlanRequest plan_;
  ExperimentMergeRequest merge_;
  ExperimentPowerRequest power_;
  ExperimentExportRequest export_;
  ExperimentLiveRequest live_;
  ExperimentForgetRequest forget_;
};

}  // namespace

std::unique_ptr<Command> make_experiment_command() {
  return std::make_unique<ExperimentCommand>();
}

}  // namespace palpate
