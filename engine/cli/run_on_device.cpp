#include "engine/cli/run_on_device.h"

#include <array>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/accuracy/stiffness_chart.h"
#include "engine/accuracy/stiffness_picture.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/device_report.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/open_device.h"
#include "engine/cli/option_names.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_recording.h"
#include "engine/cli/run_report.h"
#include "engine/cli/run_results.h"
#include "engine/cli/run_stiffness.h"
#include "engine/cli/setting_texts.h"
#include "engine/cli/start_inside_report.h"
#include "engine/cli/strategy_option.h"
#include "engine/cli/tick_times_report.h"
#include "engine/drivers/drivers.h"
#include "engine/report/text_file.h"
#include "engine/scene/memory_budget.h"
#include "engine/session/trace_csv.h"

namespace palpate {
namespace {

constexpr int kTripped = 3;

// They describe the simulated hand and the device that it holds.
constexpr std::array kHandOptions = {
    "--virtual",         "--seed",           "--workspace",
    "--device-mass",     "--device-damping", "--device-friction",
    "--encoder-quantum",
};
constexpr std::array kMotorOptions = {"--no-guard",     "--without-realtime", "--cpu",
                                      "--start-inside", "--allow-unstable",   "--energy-budget"};

std::string device_workspace_text(const DeviceDescription& device) {
  std::ostringstream text;
  text << device.workspace_high_m[0] - device.workspace_low_m[0] << " x "
       << device.workspace_high_m[1] - device.workspace_low_m[1] << " m";
  return text.str();
}

DeviceRunSettings settings_of(const RunRequest& request, const PreparedRun& prepared,
                              const IsGiven& is_given) {
  DeviceRunSettings settings;
  settings.seconds = request.exploration.seconds;
  if (request.device.cpu) settings.cpu = static_cast<int>(*request.device.cpu);
  settings.has_guard = !request.device.no_guard;
  settings.without_realtime = request.device.without_realtime;
  settings.stays_inside = request.device.stays_inside;
  settings.on_start_inside = [&scene = prepared.scene](const StartInside::Status& status) {
    const std::string line = start_inside_line(scene, status);
    if (!line.empty()) std::cerr << "palpate: " << line << std::endl;
  };
  settings.takes_motors = !is_given("--actuators") && !is_given("--actuated-axes");
  if (!request.scene.max_memory.empty()) {  // prepare_run() parsed it without an error
    settings.max_memory_bytes = *parse_bytes(request.scene.max_memory);
    settings.taken_memory_bytes = prepared.scene.statistics().memory.total();
  }
  return settings;
}

// For the table and the JSON of `run`. Copies no record.
ExplorationRun without_path(DeviceRun& run, bool a4) {
  ExplorationRun shown;
  shown.a4 = a4;
  shown.interrupted = run.interrupted;
  shown.records = std::move(run.records);
  shown.summary = run.summary;
  shown.missed_deadlines = run.missed_deadlines;
  shown.tick_times = run.tick_times;
  return shown;
}

nlohmann::ordered_json run_on_device_json(const DeviceFacts& facts, const DeviceRun& run,
                                          const ExplorationRun& shown,
                                          const std::vector<RecordingResult>& recordings,
                                          const PreparedRun& prepared) {
  nlohmann::ordered_json json{{"interrupted", signal_flag().requested()}};
  json["tripped"] = run.governor.trips > 0;
  json["device"] = device_json(facts, run);
  json["stiffness"] = facts.stiffness ? stiffness_json(*facts.stiffness) : nlohmann::ordered_json();
  json["start_inside"] = start_inside_json(prepared.scene, run.start_inside);
  json["plane_height_m"] = prepared.setup.haptics.plane_height_m;
  json["scale"] = prepared.scene.statistics().scale;
  json["work_budget"] = work_budget_json(prepared.setup);
  if (!recordings.empty()) json["recordings"] = recording_json(recordings);
  json["runs"] = nlohmann::ordered_json::array({run_json(shown, prepared.scene)});
  json["runs"][0]["reached_timing"] = reached_timing_json(prepared.setup, run.tick_times);
  json["runs"][0]["reached_timing_ends_at"] = "driver";  // without the line to the device
  return json;
}

std::string timing_text(const RunSetup& setup, const TickTimes& times) {
  const std::string reached = reached_timing_text(setup, times);
  if (reached.empty()) return reached;
  return reached + "the delay of the ticks ends at the driver\n";
}

// What ended the run before its time; empty if nothing did.
std::string ending_line(const DeviceRun& run) {
  if (run.governor.trips > 0) {
    return "the force was cut, and the run ended: " + trip_text(run.governor.trip) + "\n";
  }
  if (run.interrupted) return "interrupted; the results cover the ticks until then\n";
  return {};
}

// lost: why the trace was not written. The results are printed all the same: a person made them.
int report_run(const RunRequest& request, const PreparedRun& prepared, const DeviceFacts& facts,
               const DeviceRun& run, const ExplorationRun& shown,
               const std::vector<RecordingResult>& recordings, const std::optional<Error>& lost) {
  std::vector<std::string> warnings = load_warning_lines(prepared.scene);
  for (const std::string& warning : device_warnings(facts, run)) warnings.push_back(warning);
  for (const std::string& line : recording_warnings(recordings)) warnings.push_back(line);
  const std::string ending = ending_line(run);
  if (!ending.empty()) std::cerr << "palpate: " << ending;
  if (request.json) {
    print(run_on_device_json(facts, run, shown, recordings, prepared));
  } else {
    const std::string workspace = device_workspace_text(request.options.settings.device);
    std::cout << ending << run_heading(request, prepared, workspace)
              << (facts.stiffness ? stiffness_text(*facts.stiffness) : std::string())
              << runs_text({shown}, prepared.scene) << timing_text(prepared.setup, run.tick_times)
              << device_text(facts, run);
    if (!lost) {
      std::cout << "trace" << (facts.stiffness ? " and chart of the stiffness" : "") << " in "
                << request.out_dir << "/\n";
    }
    for (const RecordingResult& recording : recordings) std::cout << recording_text(recording);
  }
  const int finished = finish_output(warnings);
  const int code = lost ? refuse(*lost) : finished;
  return exit_code_after_signals(code == 0 && run.governor.trips > 0 ? kTripped : code);
}

std::optional<Error> write_chart(const DeviceDescription& device, const RunStiffness& stiffness,
                                 CouplingSettings coupling, const OutputFiles& files) {
  coupling.stiffness_N_per_m = stiffness.stiffness_N_per_m;
  const auto chart = stiffness_chart(device, coupling, 1.0 / stiffness.zones.period_s);
  if (!chart) return chart.error();
  for (const auto& [name, content] : {std::pair{kStiffnessPicture, stiffness_chart_svg(*chart)},
                                      std::pair{kStiffnessTable, stiffness_chart_csv(*chart)}}) {
    const auto written = write_text_file(files.path(name), content);
    if (!written) return files.in_place(written.error());
  }
  return std::nullopt;
}

// The trace, and the chart of a device that pushes. Returns why they were not written.
std::optional<Error> write_results(const DeviceDescription& device, const PreparedRun& prepared,
                                   const std::optional<RunStiffness>& stiffness,
                                   const ExplorationRun& shown, OutputFiles& files) {
  if (auto error = write_trace(files.path(trace_name(shown.a4)), shown.records)) {
    return files.in_place(*error);
  }
  if (stiffness) {
    const CouplingSettings& coupling = prepared.setup.haptics.coupling;
    if (auto error = write_chart(device, *stiffness, coupling, files)) return error;
  }
  return move_into_place(files);
}

int run_prepared(const RunRequest& request, const PreparedRun& prepared, GuardableDevice& device,
                 DeviceRunSettings settings, const std::optional<RunStiffness>& stiffness) {
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  Result<OutputFiles> files = OutputFiles::create(request.out_dir, run_file_names());
  if (!files) return refuse(files.error());
  auto recorder = make_recorder(request.record, request.scene, prepared.scene, prepared.setup,
                                false, request.device.allow_unstable.value_or(""));
  if (!recorder) return refuse(recorder.error());
  settings.sink = recorder->get();
  settings.on_start_inside = [&, tell = std::move(settings.on_start_inside)](const auto& status) {
    tell(status);
    record_start_inside(recorder->get(), prepared.scene, status);
  };
  if (stiffness) tell_stiffness(*stiffness);
  tell_energy_budgets(prepared.setup.governor.budgets);
  Result<DeviceRun> run = [&] {
    ProgressBar bar(request.a4 == A4Runs::kOn ? "with A4" : "without A4", settings.seconds);
    return run_device(
        prepared.scene, prepared.setup, device, settings, [&](double share) { bar.show(share); },
        &signal_flag());
  }();
  std::vector<RecordingResult> recordings;
  const char* const why = run && run->governor.trips > 0 ? "trip"
                          : signal_flag().requested()    ? "interrupted"
                                                         : "end";
  if (auto r = finish_recording(std::move(*recorder), why)) {
    recordings.push_back(std::move(*r));
  }
  if (!run) return refuse(run.error());
  if (run->records.empty()) return report_nothing_done();
  const ExplorationRun shown = without_path(*run, prepared.setup.haptics.a4.enabled);
  const std::optional<Error> lost =
      write_results(device.description(), prepared, stiffness, shown, *files);
  const DeviceFacts facts{device.description(),
                          request.device.text,
                          device.summary(),
                          settings.has_guard,
                          settings.without_realtime,
                          stiffness,
                          prepared.setup.governor.budgets};
  return report_run(request, prepared, facts, *run, shown, recordings, lost);
}

}  // namespace

void add_motors(CLI::App& app, DeviceRequest& device) {
  app.add_option("--device", device.text,
                 "let a person explore the scene with this device, such as "
                 "hapi:port=/dev/ttyACM0, in place of the simulated hand; `palpate devices` lists "
                 "drivers and their keys")
      ->type_name("DRIVER:KEY=VALUE,...")
      ->group(kMotorGroup);
  app.add_flag("--without-realtime", device.without_realtime,
               "run a device that keeps its last force also where the system refuses SCHED_FIFO; "
               "trips are possible on a busy machine")
      ->group(kMotorGroup);
  add_cpu(app, device.cpu)->group(kMotorGroup);
  add_choice<bool>(app, "--start-inside", device.stays_inside, {{"leave", false}, {"stay", true}},
                   "leave",
                   "if the hand begins inside a closed surface: leave, no force until it has left; "
                   "or stay, it feels the surface from inside, as in a room")
      ->group(kMotorGroup);
  app.add_option("--allow-unstable", device.allow_unstable,
                 "use a stiffness that no damping holds on this device, for this reason, which the "
                 "recording keeps")
      ->type_name("REASON")
      ->group(kMotorGroup);
  app.add_flag("--no-guard", device.no_guard,
               "for tests: start no process that stops the motors when the program hangs or ends")
      ->group(kMotorGroup);
}

std::optional<Error> check_device_options(const RunRequest& request, const IsGiven& is_given) {
  if (!is_given("--device")) {
    for (const char* option : kMotorOptions) {
      if (is_given(option)) {
        return invalid_argument(option, "is given alone; expected --device beside it");
      }
    }
    if (request.options.has_auto_stiffness) {
      return invalid_argument("--stiffness", "is auto; expected a number without --device");
    }
    return std::nullopt;
  }
  for (const char* option : kHandOptions) {
    if (is_given(option)) {
      return invalid_argument(option,
                              "is for the simulated hand; expected no such option with --device",
                              "leave one of the two out");
    }
  }
  if (is_given("--a4") && request.a4 == A4Runs::kCompare) {
    return invalid_argument("--a4", "is compare; expected on or off with --device",
                            "a person cannot repeat a motion: make two runs, with two folders "
                            "(--out)");
  }
  return std::nullopt;
}

void tell_energy_budgets(const EnergyBudgets& budgets) {
  const std::string text = energy_budgets_text(budgets);
  if (!text.empty()) std::cerr << "palpate: energy budgets: " << text << std::endl;
}

void take_strategy(RunRequest& request) {
  const auto& strategy = request.options.settings.strategy;
  if (strategy) request.a4 = has_a4(*strategy) ? A4Runs::kOn : A4Runs::kOff;
}

void set_device(const DeviceDescription& device, RunSettings& settings) {
  settings.device = device;
  const double side_m = device.workspace_high_m[0] - device.workspace_low_m[0];
  settings.device.workspace_low_m[2] = -0.5 * side_m;
  settings.device.workspace_high_m[2] = 0.5 * side_m;
  settings.sensors = device.sensed_axes;
  settings.default_actuators = device.motor_count;
  if (device.encoder_quantum_m > 0.0) settings.encoder_quantum_m = device.encoder_quantum_m;
}

void describe_device(const DeviceDescription& device, const IsGiven& is_given,
                     RunRequest& request) {
  RunSettings& settings = request.options.settings;
  set_device(device, settings);
  if (!is_given("--rate")) settings.rate_Hz = device.rate_Hz;
  if (!is_given("--stiffness")) request.options.has_auto_stiffness = true;
  settings.haptics.a4.enabled = request.a4 == A4Runs::kOn;
}

int run_on_device(RunRequest request, const IsGiven& is_given) {
  if (const auto error = check_recording_names({request.record})) return refuse(*error);
  if (const auto error = check_recording_place(request.record, request.out_dir, run_file_names())) {
    return refuse(*error);
  }
  const auto device = make_device("--device", request.device.text, request.device.no_guard);
  if (!device) return refuse(device.error());
  const DeviceDescription& description = (*device)->description();
  if (request.a4 == A4Runs::kCompare) request.a4 = A4Runs::kOff;
  const int sensors = request.options.settings.sensors;
  if (is_given("--sensors") && sensors != description.sensed_axes) {
    return refuse(invalid_argument("--sensors", "is " + std::to_string(sensors) + "; expected " +
                                                    std::to_string(description.sensed_axes) +
                                                    ", the number of sensors of the device"));
  }
  describe_device(description, is_given, request);
  Result<PreparedRun> prepared = prepare_run(request);
  if (!prepared) return refuse(with_path(prepared.error(), request.scene.path));
  if (const auto error = check_motors(request.options.settings.strategy, prepared->setup.device)) {
    return refuse(*error);
  }
  OpenDevice open(**device);
  if (const auto error = open.start()) return refuse(*error);
  const auto stiffness = choose_stiffness(request, **device, *prepared);
  if (!stiffness) return refuse(stiffness.error());
  return run_prepared(request, *prepared, **device, settings_of(request, *prepared, is_given),
                      *stiffness);
}

}  // namespace palpate
