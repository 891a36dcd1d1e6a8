// The subcommand `replay`: plays a recorded path through a scene, or computes a recording again.

#include <algorithm>
#include <array>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/recorded_replay.h"
#include "engine/cli/run_options.h"
#include "engine/cli/run_report.h"
#include "engine/cli/scene_options.h"
#include "engine/cli/start_inside_report.h"
#include "engine/cli/strategy_option.h"
#include "engine/cli/trajectory_report.h"
#include "engine/recording/recording_reader.h"
#include "engine/rig/replay.h"
#include "engine/scene/memory_budget.h"
#include "engine/session/trace_csv.h"

namespace palpate {
namespace {

class ReplayCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override;

 private:
  int replay_recording();
  Result<RunRecords> replay_with_progress(const Scene& scene, const RunSetup& setup,
                                          const PlayedPath& path) const;
  std::optional<Error> write_trace_with_progress(const std::vector<TickRecord>& records) const;

  CLI::App* app_ = nullptr;
  SceneOptions scene_;
  std::string trajectory_;
  RunOptions options_;
  std::string trace_;
  int repeat_ = 1;
  bool json_ = false;
};

CLI::App* ReplayCommand::add_to(CLI::App& program) {
  RunSettings& settings = options_.settings;
  CLI::App& app = *program.add_subcommand(
      "replay", "play a recorded device path through a scene, or prove a recording bit for bit");
  app_ = &app;
  set_help(app,
           "  ./run.sh run models/star.glb --virtual\n"
           "  ./run.sh replay models/star.glb --trajectory out/trace-off.csv --sensors 2 "
           "--actuators 1\n",
           "The first line of the example records the path that the second one plays.\n\n"
           "`replay FILE`, with a file that --record has written in place of the scene, computes "
           "the same session\nagain. Exit code 0: every bit is the same; 1: a bit differs, or "
           "ticks are missing. With --material,\n--strategy, --a4, --align, --force, --accuracy, "
           "--stiffness or --damping it shows what the same path\ngives under these settings.\n");
  app.add_option(
      "--trajectory", trajectory_,
      "device positions, one \"[t] x y z\" per line, in seconds and metres or in the units of a "
      "header such as \"t [ms], x [mm]\", or a trace of run or replay; with t, each tick takes its "
      "own time, or, with --rate, positions are interpolated; required, but for a recording");
  add_integer(app, "--repeat", repeat_, {1, 1000},
              "number of passes, 1 to 1000; the shortest time of each tick is kept");
  add_scene(app, scene_, true);
  CLI::Option* const listed_scene = app.get_option("--scene");
  listed_scene->type_name("N|NAME|FILE");
  listed_scene->description(listed_scene->get_description() +
                            "; for a recording: where the file of its scene is now");
  add_settings(app, options_, SettingGroup::kScene);
  add_settings(app, options_, SettingGroup::kDevice);
  add_settings(app, options_, SettingGroup::kTouch);
  add_choice<bool>(app, "--a4", settings.haptics.a4.enabled, {{"on", true}, {"off", false}}, "off",
                   "turn the scene while in contact")
      ->group(kA4Group);
  add_settings(app, options_, SettingGroup::kRotation);
  add_strategy(app, settings.strategy);
  app.add_option("--out", trace_, "CSV file of the trace")->group(kOutputGroup);
  add_json(app, json_);
  add_settings(app, options_, SettingGroup::kOutput);
  return &app;
}

// Of the options that a recording can be replayed with, those beside kChangedByReplay.
constexpr std::array kRecordingOptions = {"SCENE",      "--scene", "--material",
                                          "--strategy", "--a4",    "--json"};

std::string not_for_recording() {
  std::string text = "is not for a recording; expected --material, --strategy, --a4";
  for (const std::string_view option : kChangedByReplay) {
    text.append(option == kChangedByReplay.back() ? " or " : ", ").append(option);
  }
  return text;
}

int ReplayCommand::replay_recording() {
  for (const CLI::Option* option : app_->get_options()) {
    const std::string name = option->get_name();
    const bool is_known =
        std::find(kRecordingOptions.begin(), kRecordingOptions.end(), name) !=
            kRecordingOptions.end() ||
        std::find(kChangedByReplay.begin(), kChangedByReplay.end(), name) != kChangedByReplay.end();
    if (option->count() > 0 && !is_known) {
      return refuse(invalid_argument(name, not_for_recording()));
    }
  }
  const auto is_given = [this](const std::string& name) {
    return app_->get_option(name)->count() > 0;
  };
  RecordedReplayRequest request;
  request.recording = scene_.path;
  request.scene = scene_.listed_scene;
  request.json = json_;
  request.materials = scene_.materials;
  request.settings = options_.settings;
  request.strategy = options_.settings.strategy;
  if (is_given("--a4")) request.a4 = options_.settings.haptics.a4.enabled;
  for (const std::string_view option : kChangedByReplay) {
    if (is_given(std::string(option))) request.changed.emplace_back(option);
  }
  return replay_recorded(request);
}

Result<RunRecords> ReplayCommand::replay_with_progress(const Scene& scene, const RunSetup& setup,
                                                       const PlayedPath& path) const {
  ProgressBar bar("replay");
  const auto show = [&bar](double share) { bar.show(share); };
  return path.ticks_s
             ? palpate::replay(scene, setup, path.positions_m, *path.ticks_s, repeat_, show)
             : palpate::replay(scene, setup, path.positions_m, repeat_, show);
}

std::optional<Error> ReplayCommand::write_trace_with_progress(
    const std::vector<TickRecord>& records) const {
  ProgressBar bar("writing the trace");
  return write_trace(trace_, records, [&bar](double share) { bar.show(share); });
}

int ReplayCommand::run(const std::vector<std::string>&) {
  const auto is_given = [this](const std::string& name) {
    return app_->get_option(name)->count() > 0;
  };
  if (const auto error = check_strategy_options(is_given)) return refuse(*error);
  if (is_recording(scene_.path)) return replay_recording();
  if (trajectory_.empty()) {
    return refuse(invalid_argument("--trajectory", "is missing; it is required beside a scene",
                                   "or name a recording in place of the scene"));
  }
  double& rate_Hz = options_.settings.rate_Hz;
  std::optional<double> given_rate_Hz;
  if (is_given("--rate")) given_rate_Hz = rate_Hz;
  std::uint64_t max_memory_bytes = 0;
  if (!scene_.max_memory.empty()) {
    const Result<std::uint64_t> bytes = parse_bytes(scene_.max_memory);
    if (!bytes) return refuse(bytes.error());
    max_memory_bytes = *bytes;
  }
  const Result<PlayedPath> path =
      read_played_path(trajectory_, given_rate_Hz, 1.0 / rate_Hz, max_memory_bytes);
  if (!path) return refuse(path.error());
  if (path->ticks_s && path->times->median_ns > 0) {
    // The nominal rate, for the work budget. A path may be slower than any device.
    rate_Hz = std::max(1.0 / kLongestTick_s, path->times->median_rate_Hz());
  }
  const Result<RunSetup> setup = make_setup(options_);
  if (!setup) return refuse(setup.error());
  const Result<Scene> scene = load_scene(scene_, options_.settings);
  if (!scene) return refuse(scene.error());
  const Result<RunRecords> result = replay_with_progress(*scene, *setup, *path);
  if (!result) return refuse(result.error());
  // From here on a signal may not leave half a file.
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  if (!trace_.empty()) {
    if (const auto error = check_output()) return refuse(*error);
    if (const auto error = write_trace_with_progress(result->records)) return refuse(*error);
  }
  const auto enclosing =
      result->records.empty() ? std::nullopt : object_around(*scene, result->records.front());
  std::vector<std::string> warnings = load_warning_lines(*scene);
  for (std::string& warning : path_warnings(*path)) warnings.push_back(std::move(warning));
  if (enclosing) warnings.push_back(simulated_start_line(*scene, enclosing));
  if (json_) {
    nlohmann::ordered_json summary = summary_json(result->summary, *scene);
    if (auto trajectory = path_json(*path); !trajectory.is_null()) {
      summary["trajectory"] = std::move(trajectory);
    }
    summary["starts_inside"] = node_json(*scene, enclosing);
    print(summary);
  } else {
    std::cout << scene_.path << ", " << trajectory_ << path_text(*path) << "\n"
              << path_notes_text(*path) << summary_text(result->summary, *scene);
  }
  return exit_code_after_signals(finish_output(warnings));
}

}  // namespace

std::unique_ptr<Command> make_replay_command() {
  return std::make_unique<ReplayCommand>();
}

}  // namespace palpate
