#include "engine/cli/run_command.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/option_names.h"
#include "engine/cli/path_picture.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_advice.h"
#include "engine/cli/run_on_device.h"
#include "engine/cli/run_recording.h"
#include "engine/cli/run_report.h"
#include "engine/cli/run_results.h"
#include "engine/cli/start_inside_report.h"
#include "engine/cli/strategy_option.h"
#include "engine/cli/tick_times_report.h"
#include "engine/report/csv.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"
#include "engine/scene/memory_budget.h"
#include "engine/session/trace_csv.h"
#include "engine/simulation/run_judgement.h"

namespace palpate {
namespace {

constexpr int kNotComparable = 3;

// The contour or the places that the hand followed, scene frame: one point per line.
std::optional<Error> write_way(const ExplorationRun& run, const OutputFiles& files) {
  const bool is_walk = run.contour_scene_m.empty();
  CsvLines lines("x,y,z");
  for (const Vec3& p : is_walk ? run.places_scene_m : run.contour_scene_m) {
    lines.add(p.x()).add(p.y()).add(p.z()).end_line();
  }
  const std::string name =
      std::string(is_walk ? "places-" : "contour-") + (run.a4 ? "on" : "off") + ".csv";
  const auto written = write_text_file(files.path(name), lines.text());
  if (!written) return written.error();
  return std::nullopt;
}

std::optional<Error> write_run(const ExplorationRun& run, const OutputFiles& files) {
  const std::string trace = files.path(trace_name(run.a4));
  if (auto error = write_trace(trace, run.records)) return files.in_place(*error);
  if (auto error = write_way(run, files)) return files.in_place(*error);
  return std::nullopt;
}

std::optional<Error> draw(const std::vector<ExplorationRun>& runs, const ActuationModel& actuation,
                          const std::string& scene_path, const OutputFiles& files) {
  const std::string name = std::filesystem::path(scene_path).filename().string();
  const auto picture = write_path_picture(runs, actuation, name, files.path(kRunPicture));
  return picture ? std::nullopt : std::optional<Error>(files.in_place(picture.error()));
}

// A line that states what the results contain; empty if no signal arrived.
std::string interruption_line(const std::vector<ExplorationRun>& runs, bool is_comparison) {
  if (!signal_flag().requested()) return {};
  const bool was_cut = std::any_of(runs.begin(), runs.end(),
                                   [](const ExplorationRun& run) { return run.interrupted; });
  if (was_cut) return "interrupted; the results cover the ticks until then\n";
  if (is_comparison && runs.size() < 2) return "interrupted before the run with A4 began\n";
  return "interrupted after the runs had ended; the results are complete\n";
}

nlohmann::ordered_json runs_json(const PreparedRun& prepared,
                                 const std::vector<ExplorationRun>& runs,
                                 const std::vector<RecordingResult>& recordings,
                                 const std::optional<RunAdvice>& advice,
                                 std::optional<std::size_t> enclosing) {
  nlohmann::ordered_json json{{"interrupted", signal_flag().requested()},
                              {"comparable", are_comparable(runs)}};
  json["reasons"] = nlohmann::ordered_json::array();
  for (const ExplorationRun& r : runs) {
    for (const std::string& reason : reasons(r)) {
      json["reasons"].push_back((r.a4 ? "with A4: " : "without A4: ") + with_option_names(reason));
    }
  }
  json["try"] = advice ? nlohmann::ordered_json(advice->command_line) : nlohmann::ordered_json();
  json["workspace_m"] = workspace_extent_m(prepared.setup.device);
  if (prepared.setup.actuation.is_planar()) {
    json["plane_height_m"] = prepared.setup.haptics.plane_height_m;
  }
  json["scale"] = prepared.scene.statistics().scale;
  json["work_budget"] = work_budget_json(prepared.setup);
  json["starts_inside"] = node_json(prepared.scene, enclosing);
  if (!recordings.empty()) json["recordings"] = recording_json(recordings);
  json["runs"] = nlohmann::ordered_json::array();
  for (const ExplorationRun& r : runs) {
    json["runs"].push_back(run_json(r, prepared.scene));
    json["runs"].back()["reached_timing"] = r.tick_times
                                                ? reached_timing_json(prepared.setup, *r.tick_times)
                                                : nlohmann::ordered_json();
  }
  return json;
}

// Empty if nothing is recorded.
std::string recording_name(const RunRequest& command, bool a4) {
  if (command.record.empty() || command.a4 != A4Runs::kCompare) return command.record;
  return recording_name_of(command.record, a4);
}

std::optional<Error> check_recordings(const RunRequest& command) {
  std::vector<std::string> names;
  for (const bool a4 : {false, true}) {
    if (!command.record.empty() && command.wants(a4)) names.push_back(recording_name(command, a4));
  }
  for (const std::string& name : names) {
    if (const auto error = check_recording_place(name, command.out_dir, run_file_names())) {
      return error;
    }
  }
  return check_recording_names(names);
}

// The requested runs, without A4 before with A4, until a signal arrives.
Result<std::vector<ExplorationRun>> explore_and_write(const RunRequest& command,
                                                      const PreparedRun& prepared,
                                                      const OutputFiles& files,
                                                      std::vector<RecordingResult>& recordings) {
  const StopFlag& stop = signal_flag();
  ExplorationSettings exploration = command.exploration;
  if (!command.scene.max_memory.empty()) {  // prepare_run() parsed it without an error
    exploration.max_memory_bytes = *parse_bytes(command.scene.max_memory);
    exploration.taken_memory_bytes = prepared.scene.statistics().memory.total();
  }
  std::vector<ExplorationRun> runs;
  for (const bool a4 : {false, true}) {
    if (!command.wants(a4)) continue;
    if (stop.requested()) break;
    RunSetup setup = prepared.setup;
    setup.haptics.a4.enabled = a4;
    auto recorder = make_recorder(recording_name(command, a4), command.scene, prepared.scene, setup,
                                  exploration.virtual_time);
    // The disk may be full since the first run: that ends recordings, and not runs.
    if (!recorder && runs.empty()) return recorder.error();
    if (!recorder) {
      recordings.push_back({recording_name(command, a4), 0, 0, 0, recorder.error()});
      recorder = std::unique_ptr<Recorder>();
    }
    exploration.sink = recorder->get();
    ProgressBar bar(a4 ? "with A4   " : "without A4", command.exploration.seconds);
    Result<ExplorationRun> run = explore(
        prepared.scene, setup, exploration, [&](double share) { bar.show(share); }, &stop);
    if (*recorder && run && !run->records.empty()) {
      record_simulated_start(recorder->get(), prepared.scene,
                             object_around(prepared.scene, run->records.front()));
    }
    if (auto recording =
            finish_recording(std::move(*recorder), stop.requested() ? "interrupted" : "end")) {
      recordings.push_back(std::move(*recording));
    }
    if (!run) return with_path(run.error(), command.scene.path);
    if (run->records.empty()) break;
    if (const auto error = write_run(*run, files)) return *error;
    if (exploration.max_memory_bytes > 0) exploration.taken_memory_bytes += run->record_bytes();
    runs.push_back(std::move(*run));
  }
  return runs;
}

// Searches only if the runs are not comparable and no signal ended them.
std::optional<RunAdvice> find_advice(const RunRequest& command, const PreparedRun& prepared,
                                     const std::vector<ExplorationRun>& runs) {
  if (are_comparable(runs) || signal_flag().requested()) return std::nullopt;
  ProgressBar bar("searching for better options");
  return advise_run(
      command, prepared, runs, [&](double share) { bar.show(share); }, &signal_flag());
}

// The stiffness of walls at the timing of the runs; empty in simulated time.
std::string timing_text(const PreparedRun& prepared, const std::vector<ExplorationRun>& runs) {
  std::string text;
  for (const ExplorationRun& run : runs) {
    if (!run.tick_times) continue;
    text += (run.a4 ? "with A4: " : "without A4: ") +
            reached_timing_text(prepared.setup, *run.tick_times);
  }
  return text;
}

std::string workspace_text(const DeviceDescription& device) {
  std::ostringstream text;
  text << workspace_extent_m(device) << " m along each sensed axis";
  return text.str();
}

int run(const RunRequest& command) {
  if (const auto error = check_recordings(command)) return refuse(*error);
  const Result<PreparedRun> prepared = prepare_run(command);
  if (!prepared) return refuse(with_path(prepared.error(), command.scene.path));
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  Result<OutputFiles> files = OutputFiles::create(command.out_dir, run_file_names());
  if (!files) return refuse(files.error());
  std::vector<RecordingResult> recordings;
  // Recordings are whole also where the results cannot be written.
  const auto refuse_results = [&recordings](const Error& error) {
    for (const RecordingResult& recording : recordings) std::cerr << recording_text(recording);
    finish_output(recording_warnings(recordings));
    return refuse(error);
  };
  const auto done = explore_and_write(command, *prepared, *files, recordings);
  if (!done) return refuse_results(done.error());
  const std::vector<ExplorationRun>& runs = *done;
  if (runs.empty()) return report_nothing_done();
  std::vector<std::string> warnings = load_warning_lines(prepared->scene);
  if (const auto error = draw(runs, prepared->setup.actuation, command.scene.path, *files)) {
    return refuse_results(*error);
  }
  if (const auto error = move_into_place(*files)) return refuse_results(*error);
  if (const std::string& note = runs.front().realtime_note; !note.empty()) warnings.push_back(note);
  for (std::string& line : recording_warnings(recordings)) warnings.push_back(std::move(line));
  const auto enclosing = object_around(prepared->scene, runs.front().records.front());
  if (enclosing) warnings.push_back(simulated_start_line(prepared->scene, enclosing));
  const std::optional<RunAdvice> advice = find_advice(command, *prepared, runs);
  const std::string interruption = interruption_line(runs, command.a4 == A4Runs::kCompare);
  if (!interruption.empty()) std::cerr << "palpate: " << interruption;
  if (command.json) {
    print(runs_json(*prepared, runs, recordings, advice, enclosing));
  } else {
    std::cout << judgement_text(runs, advice, signal_flag().requested()) << interruption
              << run_heading(command, *prepared, workspace_text(prepared->setup.device))
              << runs_text(runs, prepared->scene) << timing_text(*prepared, runs)
              << "traces and paths.svg in " << command.out_dir << "/\n";
    for (const RecordingResult& recording : recordings) std::cout << recording_text(recording);
  }
  const int code = finish_output(warnings);
  return exit_code_after_signals(code == 0 && !are_comparable(runs) ? kNotComparable : code);
}

class RunCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override {
    request_.arguments = arguments;
    const auto is_given = [this](const std::string& name) {
      return app_->get_option(name)->count() > 0;
    };
    if (const auto error = check_strategy_options(is_given)) return refuse(*error);
    if (const auto error = check_device_options(request_, is_given)) return refuse(*error);
    take_strategy(request_);
    return request_.device.text.empty() ? palpate::run(request_)
                                        : run_on_device(request_, is_given);
  }

 private:
  RunRequest request_;
  CLI::App* app_ = nullptr;
};

CLI::App* RunCommand::add_to(CLI::App& program) {
  RunSettings& settings = request_.options.settings;
  settings.sensors = 2;
  settings.default_actuators = 1;
  CLI::App& app = *program.add_subcommand(
      "run", "let a simulated hand explore a scene in real time, without and with A4");
  app_ = &app;
  set_help(
      app,
      "  ./run.sh run models/star.glb --virtual\n"
      "  ./run.sh devices --simulate hapi --seconds 10 > board & until grep -qs /dev board; do "
      "sleep 0.1; done; ./run.sh run models/star.glb --fit auto --seconds 5 --device "
      "hapi:port=$(grep -o '/dev/[^ ]*' board)  # exit code 3: a trip\n");
  add_scene(app, request_.scene, true);
  add_settings(app, request_.options, SettingGroup::kScene);
  request_.options.states_quantum = true;
  request_.options.knows_auto_stiffness = true;
  add_settings(app, request_.options, SettingGroup::kDevice);
  ExplorationSettings& hand = request_.exploration;
  add_settings(app, request_.options, SettingGroup::kWorkspace);
  add_settings(app, request_.options, SettingGroup::kMechanics);
  add_real(app, "--seconds", hand.seconds, {2.0, 86400.0}, "length of a run, s, 2 to 86400")
      ->group(kHandGroup);
  add_integer(app, "--seed", hand.seed, {}, "seed of the hand's noise and walk")->group(kHandGroup);
  app.add_flag("--virtual", hand.virtual_time,
               "run in simulated time, as fast as the machine allows")
      ->group(kHandGroup);
  add_motors(app, request_.device);
  add_settings(app, request_.options, SettingGroup::kMotors);
  add_settings(app, request_.options, SettingGroup::kTouch);
  add_choice<A4Runs>(
      app, "--a4", request_.a4,
      {{"on", A4Runs::kOn}, {"off", A4Runs::kOff}, {"compare", A4Runs::kCompare}}, "compare",
      "turn the scene: on, off, or compare, which makes both runs; with --device: on "
      "or off [off]")
      ->group(kA4Group);
  add_settings(app, request_.options, SettingGroup::kRotation);
  add_strategy(app, settings.strategy);
  app.add_option("--out", request_.out_dir, "folder of the traces and the picture")
      ->capture_default_str()
      ->group(kOutputGroup);
  add_record(app, request_.record);
  add_json(app, request_.json);
  add_settings(app, request_.options, SettingGroup::kOutput);
  return &app;
}

}  // namespace

std::unique_ptr<Command> make_run_command() {
  return std::make_unique<RunCommand>();
}

}  // namespace palpate
