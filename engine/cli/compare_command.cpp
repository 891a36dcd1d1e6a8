// `compare`: compares strategies for missing motors on the same simulated hands and scenes.

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/python_page.h"
#include "engine/cli/run_options.h"
#include "engine/cli/run_progress.h"
#include "engine/cli/scene_options.h"
#include "engine/cli/setting_texts.h"
#include "engine/cli/shard_option.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"
#include "engine/trials/compare/compare_means.h"
#include "engine/trials/compare/compare_run.h"
#include "engine/trials/trial.h"
#include "geometry/base/file_roles.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

constexpr int kIncompleteTrials = 3;

struct CompareRequest {
  CompareSettings settings;
  SceneOptions scene;  // its path is not used
  RunOptions options;
  std::string strategies = every_strategy();
  std::string out_dir = "compare";
  std::string shard;
  std::optional<int> jobs;
  bool json = false;
};

// The settings of the device, checked. Errors name options.
Result<RunSettings> device_settings(const RunOptions& options) {
  RunSettings settings = options.settings;
  if (settings.sensors != 2) {
    return invalid_argument("--sensors", "is " + std::to_string(settings.sensors) + "; expected 2",
                            "the hands follow a contour in the plane of two sensors");
  }
  if (settings.measures_work_budget) {
    return invalid_argument("--work-budget", "is auto; expected a number",
                            "the trials are the same on every machine only with a given number");
  }
  auto axes = parse_axes(options.actuated_axes);
  if (!axes) return axes.error();
  settings.actuated_axes = std::move(*axes);
  auto place = parse_place(options.place);
  if (!place) return place.error();
  settings.haptics.initial_pose = *place;
  const auto setup = make_setup(settings);
  if (!setup) return setup.error();
  return settings;
}

Result<CompareSettings> compare_settings(const CompareRequest& request) {
  auto device = device_settings(request.options);
  if (!device) return device.error();
  auto scene = scene_settings_of(request.scene, device->haptics.god_object.radius_m);
  if (!scene) return scene.error();
  auto settings = with_strategies(request.settings, request.strategies);
  if (!settings) {
    Error error = settings.error();
    error.element = "--strategies";
    return error;
  }
  settings->device = std::move(*device);
  settings->scene = std::move(*scene);
  return settings;
}

// An error of a plan names the option that made the element of the plan.
Error with_compare_options(Error error) {
  constexpr std::pair<std::string_view, std::string_view> kOptions[] = {
      {"/operator", "--operator"}, {"/participants", "--hands"}, {"/seed", "--seed"}};
  if (!error.path.empty()) return error;
  if (error.element.starts_with("/strategies")) {
    error.element = "--strategies";
    error.hint = "leave it out of --strategies" + (error.hint.empty() ? "" : ", or " + error.hint);
  }
  for (const auto& [element, option] : kOptions) {
    if (error.element == element) error.element = option;
  }
  // A plan scales a scene by a key; the command has an option for it.
  constexpr std::string_view kFit = "fit_size_m";
  if (const std::size_t at = error.hint.find(kFit); at != std::string::npos) {
    error.hint.replace(at, kFit.size(), "--fit");
  }
  constexpr std::string_view kDevice = "/device/";
  if (error.element.starts_with(kDevice)) {
    error.element.erase(0, kDevice.size());
    error.code = ErrorCode::kInvalidArgument;  // refuse() replaces the field by the option
  }
  return error;
}

// "palpate compare" again continues where this call stopped.
int report_stopped_comparison(const CompareOutcome& outcome, const CompareRequest& request) {
  const std::size_t done = outcome.run.computed.size() + outcome.run.kept.size();
  const std::uint64_t kept_trials = outcome.run.trials_done;
  std::string text =
      "the trials of " + std::to_string(done) + " hands are complete in " + request.out_dir;
  if (kept_trials > 0) {
    text += ", " + kept_trials_text(kept_trials, "hand") + (kept_trials == 1 ? " is" : " are") +
            " kept there";
  }
  std::cerr << "palpate: interrupted; " << text << ", and the same command goes on from there\n";
  return exit_code_after_signals(0);
}

int report_shard(const CompareOutcome& outcome, const CompareRequest& request) {
  std::cout << "shard " << request.shard << " is complete in " << request.out_dir
            << "/; when all shards are there, the same command without --shard compares them\n";
  return exit_code_after_signals(finish_output(outcome.run.scene_warnings));
}

// The files that the page needs Python for; then those that are measured.
const std::vector<std::string> kPageFiles = {"report.html", "comparison.json", "comparison.csv",
                                             "a4_losses.csv"};

std::vector<std::string> result_files() {
  std::vector<std::string> names = kPageFiles;
  names.insert(names.end(), {kStrategiesFile, kMeansFile});
  return names;
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + text;
  return all;
}

// "star, lock: 160 trials of 20 hands, people2005, seed 2005", the means and what they speak of.
std::string means_text(const CompareSettings& settings,
                       const std::vector<StrategyMeans>& followings) {
  const StrategyMeans& first = followings.front();
  int trials = 0;
  for (const StrategyCounts& counts : first.counts) trials += counts.trials;
  std::string text = joined(settings.scenes) + ": " + std::to_string(trials) + " trials of " +
                     std::to_string(first.hands) + " hands of " + settings.person + ", seed " +
                     std::to_string(settings.seed) + "\n";
  for (const StrategyMeans& of : followings) {
    if (followings.size() > 1) text += "\nfollowing " + of.following + "\n";
    text += means_text(of);
  }
  return text +
         "The hands are simulated: the means speak of seeds and of the ranges in the "
         "operator file, not of people.\n";
}

std::vector<std::string> page_arguments(const CompareSettings& settings,
                                        const CompareRequest& request) {
  std::vector<std::string> arguments = {"strategies", "--operator=" + settings.person};
  for (const std::string& scene : settings.scenes) arguments.push_back("--scene=" + scene);
  if (request.json) arguments.emplace_back("--json");
  arguments.insert(arguments.end(), {"--", request.out_dir});
  return arguments;
}

// What the terminal shows. Without a page: the means.
void print_results(const CompareSettings& settings, const std::vector<StrategyMeans>& followings,
                   const CompareRequest& request, const PageOutcome& page) {
  const bool is_made = page.end == PageEnd::kMade;
  if (request.json && !is_made) {
    print(means_json(settings, followings));
  } else {
    std::cout << (is_made ? page.text : means_text(settings, followings));
  }
  if (request.json) return;
  std::cout << (is_made ? "report.html, comparison.json and 4 tables are in "
                        : "means.csv and strategies.csv are in ")
            << request.out_dir << "/\n";
}

int report_interrupted_page(const CompareRequest& request) {
  std::cerr << "palpate: interrupted; the trials are complete in " << request.out_dir
            << ", and the same command goes on from there\n";
  return exit_code_after_signals(0);
}

int report_results(const CompareSettings& settings, const CompareOutcome& outcome,
                   const CompareRequest& request) {
  const auto followings = compare_means(settings, request.out_dir);
  if (!followings) return refuse(with_compare_options(followings.error()));
  auto files = OutputFiles::create(request.out_dir, result_files());
  if (!files) return refuse(files.error());
  for (const auto& [name, text] : {std::pair(kMeansFile, means_csv(*followings)),
                                   std::pair(kStrategiesFile, strategies_csv(*followings))}) {
    const auto written = write_text_file(files->path(name), text);
    if (!written) return refuse(files->in_place(written.error()));
  }
  const auto page = place_with_page(page_arguments(settings, request), kPageFiles, *files);
  if (!page) return refuse(page.error());
  if (page->end == PageEnd::kInterrupted) return report_interrupted_page(request);
  print_results(settings, *followings, request, *page);
  const bool is_complete =
      std::all_of(followings->begin(), followings->end(),
                  [](const StrategyMeans& following) { return following.incomplete().empty(); });
  const int code = finish_output(with_page_warnings(outcome.run.scene_warnings, *page));
  return exit_code_after_signals(code == 0 && !is_complete ? kIncompleteTrials : code);
}

// The files that a comparison writes besides its trials. An input that is one of them is then
// refused before the first trial.
std::optional<Error> add_compare_outputs(const std::string& folder) {
  std::vector<std::string> paths{compare_plan_path(folder)};
  for (const std::string& name : result_files()) {
    paths.push_back((std::filesystem::path(folder) / name).string());
  }
  for (const std::string& path : paths) {
    if (auto error = add_output(path)) return error;
  }
  return std::nullopt;
}

int run_compare(const CompareRequest& request) {
  if (const auto error = add_compare_outputs(request.out_dir)) return refuse(*error);
  const auto settings = compare_settings(request);
  if (!settings) return refuse(settings.error());
  ExperimentRunSettings run;
  run.out_folder = request.out_dir;
  if (!request.shard.empty()) {
    const auto shard = parse_shard(request.shard);
    if (!shard) return refuse(shard.error());
    run.shard = *shard;
  }
  const int cores = static_cast<int>(std::min<std::size_t>(core_count(), kMostJobs));
  run.jobs = request.jobs.value_or(run.shard ? 1 : cores);
  if (const auto error = check_output()) return refuse(*error);
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  Result<CompareOutcome> outcome = CompareOutcome{};
  {
    ProgressBar bar("compare");
    outcome =
        run_comparison(*settings, run, {find_trial_way, run_trial}, shown_in(bar), &signal_flag());
  }
  if (!outcome) return refuse(with_compare_options(outcome.error()));
  if (!outcome->run.not_done.empty()) return report_stopped_comparison(*outcome, request);
  if (run.shard) return report_shard(*outcome, request);
  return report_results(*settings, *outcome, request);
}

class CompareCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>&) override { return run_compare(request_); }

 private:
  void add_scenes(CLI::App& app);
  void add_hands(CLI::App& app);

  CompareRequest request_;
};

// Removes options that a comparison sets itself, or that its plan does not have.
void remove_options(CLI::App& app, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (CLI::Option* const option = app.get_option_no_throw(name)) app.remove_option(option);
  }
}

void CompareCommand::add_scenes(CLI::App& app) {
  add_scene(app, request_.scene, false);
  add_settings(app, request_.options, SettingGroup::kScene);
  remove_options(app, {"SCENE", "--material", "--max-memory", "--move"});
  app.add_option("SCENE", request_.settings.scenes,
                 "glTF 2.0 files, .gltf or .glb; the options of the scene apply to each of them")
      ->required();
}

void CompareCommand::add_hands(CLI::App& app) {
  CompareSettings& settings = request_.settings;
  app.add_option("--strategies", request_.strategies,
                 "list of " + strategies_help() + ", separated by commas")
      ->capture_default_str()
      ->group(kHandGroup);
  add_integer(app, "--hands", settings.hands, {2, kMostParticipants}, "simulated hands, 2 or more")
      ->group(kHandGroup);
  app.add_option("--operator", settings.person,
                 "people2005, literature, or an operator file: the ranges of the hands")
      ->capture_default_str()
      ->group(kHandGroup);
  app.add_flag("--followings", settings.has_all_followings,
               "compare with hands of all followings; otherwise with delayed alone")
      ->group(kHandGroup);
  add_integer(app, "--seed", settings.seed, {0, (std::uint64_t{1} << 53) - 1}, "seed of the hands")
      ->group(kHandGroup);
  add_integer(app, "--jobs", request_.jobs, {1, kMostJobs},
              "hands to compute at the same time [the number of cores; 1 for a shard]")
      ->group(kHandGroup);
  app.add_option("--shard", request_.shard,
                 "i/n: compute the hands i, i + n, i + 2 n, ... only, into a folder that the "
                 "shards share; a call without this option then compares")
      ->type_name("i/n")
      ->group(kHandGroup);
}

CLI::App* CompareCommand::add_to(CLI::App& program) {
  RunSettings& settings = request_.options.settings;
  settings.sensors = 2;
  settings.default_actuators = 1;
  CLI::App& app = *program.add_subcommand(
      "compare", "compare techniques for missing motors on the same simulated hands");
  set_help(
      app, "  ./run.sh compare models/star.glb --hands 4 --strategies mask,a4\n",
      "Each hand follows the contour of each scene once with each strategy, with the same "
      "random numbers.\nDIR/report.html states which technique is best by which measure, and "
      "where A4 loses;\ncomparison.json and CSV files have all numbers. DIR/plan.json is the plan, "
      "DIR/trials has the\ntrials. Another comparison in DIR is replaced. If the command "
      "is interrupted, the same command\ncomputes the missing trials only. `anisotropic` stands "
      "for six values of E, each with\na column of its own; no strategy is tuned.\n"
      "Exit code 3: fewer than 90 % of a strategy's trials ended at the red sphere.\n");
  add_scenes(app);
  add_settings(app, request_.options, SettingGroup::kDevice);
  remove_options(app, {"--force", "--strategy"});
  add_settings(app, request_.options, SettingGroup::kWorkspace);
  add_settings(app, request_.options, SettingGroup::kMechanics);
  add_hands(app);
  add_settings(app, request_.options, SettingGroup::kTouch);
  add_settings(app, request_.options, SettingGroup::kRotation);
  app.add_option("--out", request_.out_dir, "folder of the results")
      ->capture_default_str()
      ->group(kOutputGroup);
  add_json(app, request_.json);
  return &app;
}

}  // namespace

std::unique_ptr<Command> make_compare_command() {
  return std::make_unique<CompareCommand>();
}

}  // namespace palpate
