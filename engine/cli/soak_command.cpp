// The subcommand `soak`: runs the haptic thread for a long time, and reports late ticks and memory.

#include <algorithm>
#include <array>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/formatted.h"
#include "engine/cli/number_option.h"
#include "engine/cli/prepared_run.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/run_report.h"
#include "engine/cli/run_results.h"
#include "engine/cli/soak_on_devices.h"
#include "engine/cli/start_inside_report.h"
#include "engine/cli/tick_times_report.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"
#include "engine/simulation/calm_chart.h"
#include "engine/simulation/soak.h"

namespace palpate {
namespace {

constexpr double kMostMinutes = 60.0 * 24.0;
constexpr const char* kReportName = "soak.txt";
constexpr const char* kJsonName = "soak.json";
constexpr const char* kCpuTimesName = "cpu_ns.u32";

std::string times_line(const char* name, const TimeHistogram& times) {
  if (times.count() == 0) {
    return formatted("%-34s %10s %10s %10s %10s\n", name, "-", "-", "-", "-");
  }
  const auto us = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
  return formatted("%-34s %10.1f %10.1f %10.1f %10.1f\n", name, us(times.percentile_ns(0.5)),
                   us(times.percentile_ns(0.99)), us(times.percentile_ns(0.999)),
                   us(times.largest_ns()));
}

std::string late_ticks_text(const SoakRun& run) {
  const TickTimes& times = run.tick_times;
  std::string text =
      formatted("late ticks: %llu of %llu", static_cast<unsigned long long>(times.all_late_ticks()),
                static_cast<unsigned long long>(run.summary.ticks)) +
      late_causes_text(times) + "\n";
  if (times.all_late_ticks() == 0) return text;
  const TickCost& longest = times.longest;
  const std::string_view cause = kLateCauseNames[static_cast<std::size_t>(cause_of(longest))];
  return text + formatted(
                    "longest: %.3f ms after its due time (%s), of which %.3f ms before its "
                    "start; CPU time %.1f us\n",
                    1e-6 * static_cast<double>(longest.late_ns + longest.wall_ns),
                    std::string(cause).c_str(), 1e-6 * static_cast<double>(longest.late_ns),
                    1e-3 * static_cast<double>(longest.cpu_ns));
}

std::string memory_text(const SoakRun& run) {
  const auto grown = [](std::int64_t from, std::int64_t to) {
    return static_cast<long long>(to - from);
  };
  return formatted(
      "memory after the first second: heap %+lld bytes, resident %+lld bytes; page faults "
      "of the haptic thread %lld\n",
      grown(run.memory_at_start.heap, run.memory_at_end.heap),
      grown(run.memory_at_start.resident, run.memory_at_end.resident),
      static_cast<long long>(run.tick_times.faults));
}

std::string touch_text(const RunSummary& s, const Scene& scene) {
  std::string effects;
  for (const std::string& effect : scene.effects().effects) {
    effects += effect + " active in " + effect_use_text(s, effect) + "\n";
  }
  return formatted(
             "in contact %.1f %%, %llu losses of contact, A4 turned the scene in %llu ticks\n",
             100.0 * s.contact_share(), static_cast<unsigned long long>(s.losses_of_contact),
             static_cast<unsigned long long>(s.a4_ticks)) +
         effects + "faults: " + faults_text(s) + "\n";
}

std::string soak_text(const SoakRun& run, const PreparedRun& prepared) {
  const RunSetup& setup = prepared.setup;
  const TickTimes& times = run.tick_times;
  std::string text =
      formatted("%-34s %10s %10s %10s %10s\n", "us", "50 %", "99 %", "99.9 %", "worst");
  text += times_line("start after due time", times.late);
  text += times_line("period", times.period);
  text += times_line("reading the device to command", times.delay);
  text += times_line("loop", times.step);
  text += times_line("CPU time of a tick, hand included", times.cpu);
  text += formatted("worst CPU time: %.2f %% of the period\n",
                    1e-7 * static_cast<double>(times.cpu.largest_ns()) / setup.dt_s);
  text += late_ticks_text(run) + reached_timing_text(setup, times);
  text += formatted("ticks with a number that is not finite: %llu\n",
                    static_cast<unsigned long long>(run.ticks_not_finite));
  return text + memory_text(run) + touch_text(run.summary, prepared.scene);
}

nlohmann::ordered_json memory_json(const ProcessMemory& memory) {
  return {{"heap_bytes", memory.heap}, {"resident_bytes", memory.resident}};
}

nlohmann::ordered_json late_log_json(const LateTickLog& log) {
  nlohmann::ordered_json ticks = nlohmann::ordered_json::array();
  for (const LateTick& t : log.ticks()) {
    const std::string_view cause = kLateCauseNames[static_cast<std::size_t>(cause_of(t.cost))];
    ticks.push_back({{"tick", t.tick},
                     {"cause", cause},
                     {"late_ns", t.cost.late_ns},
                     {"wall_ns", t.cost.wall_ns},
                     {"cpu_ns", t.cost.cpu_ns}});
  }
  return ticks;
}

nlohmann::ordered_json soak_json(const SoakRun& run, const PreparedRun& prepared) {
  nlohmann::ordered_json summary = summary_json(run.summary, prepared.scene);
  for (const char* key : {"step_ns", "step_ns_clock"}) summary.erase(key);  // tick_times has it
  nlohmann::ordered_json json = {{"interrupted", run.interrupted},
                                 {"rate_Hz", 1.0 / prepared.setup.dt_s},
                                 {"sensors", prepared.setup.actuation.sensors()},
                                 {"actuators", prepared.setup.actuation.actuators()},
                                 {"work_budget", work_budget_json(prepared.setup)},
                                 {"fifo", run.realtime.fifo_priority},
                                 {"locked_memory", run.realtime.locked_memory},
                                 {"tick_times", tick_times_json(run.tick_times)}};
  json["starts_inside"] = node_json(prepared.scene, run.starts_inside);
  json["reached_timing"] = reached_timing_json(prepared.setup, run.tick_times);
  json["worst_cpu_share"] =
      1e-9 * static_cast<double>(run.tick_times.cpu.largest_ns()) / prepared.setup.dt_s;
  json["first_late_ticks"] = late_log_json(run.tick_times.late_log);
  json["ticks_not_finite"] = run.ticks_not_finite;
  json["memory_after_1_s"] = memory_json(run.memory_at_start);
  json["memory_at_end"] = memory_json(run.memory_at_end);
  json.update(summary);
  return json;
}

// Little-endian.
std::string bytes_of(const std::vector<std::uint32_t>& numbers) {
  std::string bytes;
  bytes.reserve(4 * numbers.size());
  for (const std::uint32_t number : numbers) {
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 255u);
  }
  return bytes;
}

class SoakCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>& arguments) override;

 private:
  std::string heading(const PreparedRun& prepared, const SoakRun& run) const;
  int report(const PreparedRun& prepared, const SoakRun& run, OutputFiles& files) const;
  int run_on_devices() const;

  RunRequest request_;
  double minutes_ = 1.0;
  std::optional<std::uint64_t> cpu_;
  bool keeps_cpu_times_ = false;
  bool is_on_devices_ = false;
  std::optional<std::uint64_t> cases_;
  CLI::App* app_ = nullptr;
};

CLI::App* SoakCommand::add_to(CLI::App& program) {
  RunSettings& settings = request_.options.settings;
  settings.default_actuators = 2;
  settings.haptics.a4.enabled = true;
  request_.a4 = A4Runs::kOn;
  CLI::App& app = *program.add_subcommand(
      "soak", "run the haptic thread for a long time, and report late ticks and memory");
  set_help(app,
           "  ./run.sh soak models/star.glb --minutes 0.1\n"
           "  ./run.sh soak --device --cases 20\n",
           "With --device, 1 also means that a case broke a promise.\n");
  app_ = &app;
  add_scene(app, request_.scene, /* is_required = */ false);
  app.add_flag(
         "--device", is_on_devices_,
         "in place of a scene: random contacts of simulated devices with motors, in simulated "
         "time; does each tip come to rest?")
      ->group(kMotorGroup);
  add_integer(app, "--cases", cases_, {1, kMostChartCases}, "contacts of --device [200]")
      ->group(kMotorGroup);
  add_settings(app, request_.options, SettingGroup::kScene);
  add_settings(app, request_.options, SettingGroup::kDevice);
  add_settings(app, request_.options, SettingGroup::kWorkspace);
  add_settings(app, request_.options, SettingGroup::kMechanics);
  add_real(app, "--minutes", minutes_, {2.0 / 60.0, kMostMinutes}, "length of the run, minutes")
      ->group(kHandGroup);
  add_integer(app, "--seed", request_.exploration.seed, {}, "seed of the hand's noise and walk")
      ->group(kHandGroup);
  add_cpu(app, cpu_)->group(kHandGroup);
  add_settings(app, request_.options, SettingGroup::kTouch);
  add_choice<bool>(app, "--a4", settings.haptics.a4.enabled, {{"on", true}, {"off", false}}, "on",
                   "turn the scene while in contact")
      ->group(kA4Group);
  add_settings(app, request_.options, SettingGroup::kRotation);
  app.add_option("--out", request_.out_dir, "folder of the report, soak.txt and soak.json")
      ->capture_default_str()
      ->group(kOutputGroup);
  app.add_flag(
         "--cpu-times", keeps_cpu_times_,
         "also write cpu_ns.u32: the CPU time of each tick, ns, as a 32-bit number, little-endian")
      ->group(kOutputGroup);
  add_json(app, request_.json);
  add_settings(app, request_.options, SettingGroup::kOutput);
  return &app;
}

std::string SoakCommand::heading(const PreparedRun& prepared, const SoakRun& run) const {
  std::ostringstream workspace;
  workspace << workspace_extent_m(prepared.setup.device) << " m along each sensed axis";
  std::string text = run_heading(request_, prepared, workspace.str());
  text += formatted("%.6g Hz for %.6g min, A4 %s, SCHED_FIFO %s, memory %s\n",
                    1.0 / prepared.setup.dt_s, minutes_,
                    prepared.setup.haptics.a4.enabled ? "on" : "off",
                    run.realtime.fifo_priority ? "granted" : "refused",
                    run.realtime.locked_memory ? "locked" : "not locked");
  if (run.interrupted) text += "interrupted; the report covers the ticks until then\n";
  return text;
}

int SoakCommand::report(const PreparedRun& prepared, const SoakRun& run, OutputFiles& files) const {
  const std::string text = heading(prepared, run) + soak_text(run, prepared);
  const nlohmann::ordered_json json = soak_json(run, prepared);
  for (const auto& [name, content] :
       {std::pair{kReportName, text}, std::pair{kJsonName, json.dump(2) + "\n"},
        std::pair{kCpuTimesName, bytes_of(run.cpu_ns)}}) {
    if (content.empty()) continue;
    const auto written = write_text_file(files.path(name), content);
    if (!written) return refuse(files.in_place(written.error()));
  }
  if (const auto error = move_into_place(files)) return refuse(*error);
  if (request_.json) {
    print(json);
  } else {
    std::cout << text << "report in " << request_.out_dir << "/\n";
  }
  std::vector<std::string> warnings = load_warning_lines(prepared.scene);
  if (run.starts_inside) {
    warnings.push_back(simulated_start_line(prepared.scene, run.starts_inside));
  }
  if (!run.realtime.explanation.empty()) warnings.push_back(run.realtime.explanation);
  return exit_code_after_signals(finish_output(warnings));
}

int SoakCommand::run_on_devices() const {
  constexpr std::array<std::string_view, 6> kTaken = {"--device", "--cases", "--seed",
                                                      "--rate",   "--out",   "--json"};
  for (const CLI::Option* option : app_->get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || std::find(kTaken.begin(), kTaken.end(), name) != kTaken.end()) {
      continue;
    }
    return refuse(invalid_argument(name,
                                   "is given beside --device; expected none but --cases, "
                                   "--seed, --rate, --out and --json"));
  }
  ChartRequest chart;
  chart.seed = request_.exploration.seed;
  chart.out_dir = request_.out_dir;
  chart.cases = cases_.value_or(chart.cases);
  chart.json = request_.json;
  if (app_->count("--rate") > 0) {
    chart.rate_Hz = request_.options.settings.rate_Hz;
    using Range = ChartRange;
    if (!(*chart.rate_Hz >= Range::kLeastRate_Hz && *chart.rate_Hz <= Range::kMostRate_Hz)) {
      return refuse(invalid_argument("--rate", "is " + formatted("%g", *chart.rate_Hz) +
                                                   " Hz; expected 250 to 10000 Hz beside "
                                                   "--device"));
    }
  }
  return soak_on_devices(chart);
}

int SoakCommand::run(const std::vector<std::string>& arguments) {
  request_.arguments = arguments;
  if (is_on_devices_) return run_on_devices();
  if (cases_) {
    return refuse(invalid_argument("--cases", "is given alone; expected --device beside it"));
  }
  if (request_.scene.path.empty()) {
    return refuse(invalid_argument("SCENE", "is missing; expected a glTF file, or --device"));
  }
  const Result<PreparedRun> prepared = prepare_run(request_);
  if (!prepared) return refuse(with_path(prepared.error(), request_.scene.path));
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  Result<OutputFiles> files =
      OutputFiles::create(request_.out_dir, {kCpuTimesName, kReportName, kJsonName});
  if (!files) return refuse(files.error());
  SoakSettings settings;
  settings.seconds = 60.0 * minutes_;
  settings.seed = request_.exploration.seed;
  settings.keeps_cpu_times = keeps_cpu_times_;
  if (cpu_) settings.cpu = static_cast<int>(*cpu_);
  const Result<SoakRun> done = [&] {
    ProgressBar bar("soak", settings.seconds);
    return soak(
        prepared->scene, prepared->setup, settings, [&](double share) { bar.show(share); },
        &signal_flag());
  }();
  if (!done) return refuse(with_path(done.error(), request_.scene.path));
  if (done->summary.ticks == 0) return report_nothing_done();
  return report(*prepared, *done, *files);
}

}  // namespace

std::unique_ptr<Command> make_soak_command() {
  return std::make_unique<SoakCommand>();
}

}  // namespace palpate
