// The subcommand `replay`: plays a recorded path through a scene.

#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/report.h"
#include "engine/cli/run_options.h"
#include "engine/cli/scene_options.h"
#include "engine/session/replay.h"
#include "engine/session/trace_csv.h"
#include "io/trajectory.h"

namespace palpate {
namespace {

class ReplayCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override;

 private:
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
      "replay", "play a recorded device path through a scene, with the same bits every time");
  set_help(app,
           "  ./run.sh run models/star.glb --virtual\n"
           "  ./run.sh replay models/star.glb --trajectory out/trace-off.csv --sensors 2 "
           "--actuators 1\n",
           "The first line of the example records the path that the second one plays.\n");
  app.add_option(
         "--trajectory", trajectory_,
         "device positions, one \"[t] x y z\" per line, in metres, or a trace of run or replay")
      ->required();
  add_integer(app, "--repeat", repeat_, {1, 1000},
              "number of passes, 1 to 1000; the shortest time of each tick is kept");
  add_scene(app, scene_, true);
  add_place(app, options_);
  add_device(app, options_, "step of the device's encoders, m; required by the adaptive estimator");
  add_touch(app, settings);
  add_choice<bool>(app, "--a4", settings.a4, {{"on", true}, {"off", false}}, "off",
                   "turn the scene while in contact")
      ->group(kA4Group);
  add_rotation(app, settings);
  app.add_option("--out", trace_, "CSV file of the trace")->group(kOutputGroup);
  add_output(app, settings, json_);
  return &app;
}

int ReplayCommand::run(const std::vector<std::string>&) {
  const Result<RunSetup> setup = make_setup(options_);
  if (!setup) return refuse(setup.error());
  const Result<std::vector<Vec3>> path = read_trajectory(trajectory_);
  if (!path) return refuse(path.error());
  const Result<Scene> scene = load_scene(scene_, options_.settings);
  if (!scene) return refuse(scene.error());
  const Result<ReplayResult> result = palpate::replay(*scene, *setup, *path, repeat_);
  if (!result) return refuse(result.error());
  // From here on a signal may not leave half a file.
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  if (!trace_.empty()) {
    if (const auto error = check_output()) return refuse(*error);
    if (const auto error = write_trace(trace_, result->records)) {
      return refuse(*error);
    }
  }
  if (json_) {
    print(summary_json(result->summary, *scene));
  } else {
    std::cout << scene_.path << ", " << trajectory_ << "\n"
              << summary_text(result->summary, *scene);
  }
  return exit_code_after_signals(finish_output(not_understood_lines(*scene)));
}

}  // namespace

std::unique_ptr<Command> make_replay_command() {
  return std::make_unique<ReplayCommand>();
}

}  // namespace palpate
