// `accuracy`: measures what accuracy costs in time, and recommends settings.

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/accuracy/accuracy_csv.h"
#include "engine/accuracy/accuracy_json.h"
#include "engine/accuracy/advice.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/machine_load.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/recommendation.h"
#include "engine/accuracy/scene_findings.h"
#include "engine/accuracy/stiffness_chart.h"
#include "engine/accuracy/stiffness_picture.h"
#include "engine/cli/all_commands.h"
#include "engine/cli/command_help.h"
#include "engine/cli/command_line.h"
#include "engine/cli/command_output.h"
#include "engine/cli/effects_report.h"
#include "engine/cli/number_option.h"
#include "engine/cli/program_signals.h"
#include "engine/cli/python_page.h"
#include "engine/cli/run_options.h"
#include "engine/cli/scene_options.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/report/human_units.h"
#include "engine/report/output_files.h"
#include "engine/report/text_file.h"

namespace palpate {
namespace {

constexpr const char* kSceneOptionsGroup = "With a SCENE";

// The longest delay that stability_limits() takes at the highest rate that the report tries, 32
// kHz.
constexpr NumberRange kWallDelay_s{0.0, ServoTiming::kMostDelayTicks / 32e3};

struct AccuracyRequest {
  SceneOptions scene;  // an empty path: no scene
  RunSettings settings;
  bool asks_rate = false;          // --rate was given
  double delay_s = 0.0;            // from a sample of the device to its force; 0: none
  std::vector<std::string> knobs;  // only these knobs; empty: all
  bool quick = false;
  std::uint64_t seed = 1;
  std::string out_dir = "accuracy";
};

// The knob that simplifies the scene's own mesh.
constexpr const char* kSceneKnob = "scene_resolution";

bool is_chosen(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

// The knobs chosen, in the order of the report, without the knob of a scene.
Result<std::vector<Knob>> chosen_knobs(const MeasurementEffort& effort,
                                       const DeviceDescription& device,
                                       const std::vector<std::string>& names, bool has_scene) {
  std::vector<Knob> all = all_knobs(effort, device);
  if (names.empty()) return all;
  std::string known;
  for (const Knob& knob : all) known += (known.empty() ? "" : ", ") + knob.name;
  known += std::string(", and with a SCENE ") + kSceneKnob;
  std::vector<Knob> chosen;
  for (const std::string& name : names) {
    const bool is_known =
        (has_scene && name == kSceneKnob) ||
        std::any_of(all.begin(), all.end(), [&](const Knob& k) { return k.name == name; });
    if (!is_known)
      return invalid_argument("--knob", "is \"" + name + "\"; expected one of " + known);
  }
  for (Knob& knob : all) {
    if (is_chosen(names, knob.name)) chosen.push_back(std::move(knob));
  }
  return chosen;
}

// Checks the numbers of the device; an error names the option.
std::optional<Error> check_device(const RunSetup& setup) {
  const auto limits =
      stability_limits(wall_mechanics(setup.device), setup.haptics.coupling.damping_Ns_per_m,
                       {setup.dt_s, wall_delay_s(setup.device)});
  if (limits) return std::nullopt;
  Error error = limits.error();
  constexpr std::pair<const char*, const char*> kOptions[] = {
      {"mass", "--device-mass"},
      {"damping", "--device-damping"},
      {"Coulomb friction", "--device-friction"},
      {"encoder quantum", "--encoder-quantum"}};
  for (const auto& [name, option] : kOptions) {
    if (error.element == name) error.element = option;
  }
  return error;
}

std::vector<KnobResult> measure_all(const std::vector<Knob>& knobs,
                                    const MeasurementEffort& effort) {
  ProgressBar bar("accuracy");
  std::vector<KnobResult> results;
  for (std::size_t i = 0; i < knobs.size(); ++i) {
    const auto of_all = [&](double share) {
      return (static_cast<double>(i) + share) / static_cast<double>(knobs.size());
    };
    const std::string label = "accuracy: " + knobs[i].name;
    bar.show(label, of_all(0.0));
    results.push_back(
        measure(knobs[i], effort, [&](double share) { bar.show(label, of_all(share)); }));
  }
  reconcile(results);
  return results;
}

// The rates that the machine keeps, or the rate of the loop if it keeps none.
std::vector<double> rates_kept_Hz(const KeptRate& kept, double rate_Hz) {
  std::vector<double> rates;
  for (const RateTrial& trial : kept.trials) {
    if (trial.passed()) rates.push_back(trial.rate_Hz);
  }
  if (rates.empty()) rates.push_back(rate_Hz);
  return rates;
}

Result<SceneFindings> measure_findings(const Scene& scene, const AccuracyRequest& command,
                                       const RunSetup& setup, const MeasurementEffort& effort) {
  SceneFindings findings;
  findings.path = command.scene.path;
  findings.device = setup.device;
  findings.rate_Hz = command.settings.rate_Hz;
  ProgressBar bar("accuracy of the scene");
  Result<SceneAccuracy> measured =
      measure_scene(scene, setup, effort, [&](double share) { bar.show(share); });
  if (!measured) return measured.error();
  findings.measured = std::move(*measured);
  const auto verdicts =
      judge_couplings(couplings_of(scene, setup.haptics.coupling), setup.device,
                      {setup.dt_s, wall_delay_s(setup.device)}, findings.measured.deepest_m);
  if (!verdicts) return verdicts.error();
  findings.verdicts = *verdicts;
  for (const double rate_Hz :
       rates_kept_Hz(findings.measured.kept_rate, command.settings.rate_Hz)) {
    const auto limits =
        stability_limits(wall_mechanics(setup.device), setup.haptics.coupling.damping_Ns_per_m,
                         {1.0 / rate_Hz, wall_delay_s(setup.device)});
    if (!limits) return limits.error();
    findings.by_rate.push_back({rate_Hz, *limits});
  }
  return findings;
}

// The options of `palpate run` that load the same scene.
std::vector<std::string> options_of_run(const SceneOptions& scene) {
  if (scene.path.empty()) return {};
  std::vector<std::string> options{scene.path};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) options.insert(options.end(), {option, value});
  };
  const auto add_number = [&](const char* option, const std::optional<double>& value) {
    if (value) add(option, shortest_digits(*value));
  };
  add("--scene", scene.listed_scene);
  if (scene.feels_hidden) options.push_back("--feel-hidden");
  add("--node", scene.node);
  add_number("--scale", scene.scale);
  add_number("--fit", scene.fit_size_m);
  add_number("--close-gaps", scene.close_gaps_m);
  if (!scene.scale && !scene.fit_size_m) add("--fit", "auto");
  add("--pose", scene.pose);
  for (const std::string& material : scene.materials) add("--material", material);
  add("--max-memory", scene.max_memory);
  return options;
}

constexpr const char* kTable = "raw.csv";
constexpr const char* kSceneTable = "scene.csv";
constexpr const char* kZonesTable = "stiffness_zones.csv";
constexpr const char* kZonesPicture = "stiffness.svg";
constexpr const char* kJson = "accuracy.json";
constexpr const char* kPage = "report.html";

// The page, and a diagram per knob, which Python makes.
std::vector<std::string> page_names(const MeasurementEffort& effort) {
  std::vector<std::string> names{kPage, std::string(kSceneKnob) + ".svg"};
  for (const Knob& knob : all_knobs(effort)) names.push_back(knob.name + ".svg");
  return names;
}

// Every file that `accuracy` may write.
std::vector<std::string> accuracy_file_names(const MeasurementEffort& effort) {
  std::vector<std::string> names{kTable, kSceneTable, kZonesTable, kZonesPicture, kJson};
  for (std::string& name : page_names(effort)) names.push_back(std::move(name));
  return names;
}

std::optional<Error> write_measured(const AccuracyResults& all, const OutputFiles& files) {
  std::vector<std::pair<const char*, std::string>> contents{
      {kTable, accuracy_csv(all.knobs)},
      {kZonesTable, stiffness_chart_csv(all.chart)},
      {kZonesPicture, stiffness_chart_svg(all.chart)},
      {kJson, accuracy_json(all)}};
  if (all.scene != nullptr) contents.emplace_back(kSceneTable, scene_csv(*all.scene));
  for (const auto& [name, content] : contents) {
    const auto written = write_text_file(files.path(name), content);
    if (!written) return files.in_place(written.error());
  }
  return std::nullopt;
}

// The cores that other programs used since then; 0 if the system does not say.
double others_cores(const std::optional<CpuTimes>& before) {
  const auto now = cpu_times_now();
  return before && now ? cores_of_others(*before, *now) : 0.0;
}

// Checks that results can be written, and keeps other commands out of the folder. It has no file
// until write_in_place(), because a signal ends the measurements at once.
Result<OutputFiles> take_out_folder(const std::string& folder, const MeasurementEffort& effort) {
  const SignalPhaseScope not_now(SignalPhase::kDeferred);
  auto files = OutputFiles::create(folder, accuracy_file_names(effort));
  if (files) files->pause();
  return files;
}

// Writes what was measured, and has the page made. After a signal the old files stay; else they are
// replaced, also where the page could not be made.
Result<PageOutcome> write_in_place(const AccuracyResults& all, OutputFiles& files) {
  if (auto error = files.resume()) return *error;
  if (auto error = write_measured(all, files)) return *error;
  return place_with_page({"accuracy", "--", files.hidden_folder()}, page_names(all.effort), files);
}

// The last line of the answer: what is where.
std::string files_text(const AccuracyRequest& command, bool has_page, bool has_scene) {
  return std::string(has_page ? "report.html, a diagram per knob, " : "") +
         "raw.csv, stiffness_zones.csv" + (has_scene ? ", scene.csv" : "") +
         " and accuracy.json are in " + command.out_dir + "/\n";
}

int report_nothing_is_written() {
  std::cerr << "palpate: interrupted; nothing is written\n";
  return exit_code_after_signals(0);
}

// Orders with a theory, as "fitted (theory)".
std::string order_text(const KnobResult& result) {
  std::string text;
  for (const MethodResult& method : result.methods) {
    if (!method.expected_order || !method.order) continue;
    text += (text.empty() ? "" : ", ") + short_number(*method.order) + " (" +
            short_number(*method.expected_order) + ")";
  }
  return text;
}

std::string place_text(const KnobResult& result, const LevelPlace& place) {
  const MethodResult& method = result.methods[place.method];
  const std::string& label = method.levels[place.level].label;
  return result.methods.size() == 1 ? label : label + ", " + method.name;
}

using Row = std::vector<std::string>;

Row row_of(const KnobResult& result) {
  const LevelPlace usual = result.default_place();
  const LevelResult& level = result.methods[usual.method].levels[usual.level];
  // There are no figures if every repeat failed.
  return {result.knob.name,
          place_text(result, usual),
          level.was_measured() ? (level.at_floor ? "\u2264 " : "") +
                                     human(level.error.median, result.knob.error.unit)
                               : "failed",
          level.was_measured() ? human(level.time.median, result.knob.time.unit) : "-",
          result.default_is_on_front() ? "yes" : "no, see report",
          result.recommended ? place_text(result, *result.recommended)
          : result.undecided ? "none, see report"
                             : "none",
          order_text(result)};
}

// Columns on a terminal: the continuation bytes of a UTF-8 character take none.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

std::string table_text(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i] + std::string(widths[i] - width_of(row[i]) + 2, ' ');
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string knobs_text(const std::vector<KnobResult>& results) {
  std::vector<Row> rows{
      {"knob", "default", "error", "time", "on the front", "recommended", "order (theory)"}};
  for (const KnobResult& result : results) rows.push_back(row_of(result));
  return table_text(rows);
}

int accuracy(const AccuracyRequest& command) {
  RunSettings settings = command.settings;
  settings.device.delay = {command.delay_s, command.delay_s};
  const Result<RunSetup> setup = make_setup(settings);
  if (!setup) return refuse(setup.error());
  if (const auto error = check_device(*setup)) return refuse(*error);
  const MeasurementEffort effort{command.quick, command.seed};
  Result<std::vector<Knob>> knobs =
      chosen_knobs(effort, setup->device, command.knobs, !command.scene.path.empty());
  if (!knobs) return refuse(knobs.error());
  // Checked before measuring, which takes minutes.
  auto files = take_out_folder(command.out_dir, effort);
  if (!files) return refuse(files.error());
  if (signal_flag().requested()) return report_nothing_is_written();

  const auto before = cpu_times_now();
  std::optional<Scene> scene;
  std::optional<SceneFindings> findings;
  if (!command.scene.path.empty()) {
    Result<Scene> loaded = load_scene(command.scene, command.settings);
    if (!loaded) return refuse(loaded.error());
    scene.emplace(std::move(*loaded));
    Result<SceneFindings> found = measure_findings(*scene, command, *setup, effort);
    if (!found) {
      Error error = found.error();
      if (error.path.empty()) error.path = command.scene.path;
      return refuse(error);
    }
    findings = std::move(*found);
    if (is_chosen(command.knobs, kSceneKnob)) {
      auto resolution = simplification_knob(*scene, *setup, effort, findings->no_simplification);
      if (resolution) knobs->push_back(std::move(*resolution));
    }
  }

  const std::vector<KnobResult> results = measure_all(*knobs, effort);
  const auto advice =
      advise({results, findings ? &*findings : nullptr, setup->device, setup->haptics.coupling,
              command.asks_rate ? std::optional(command.settings.rate_Hz) : std::nullopt,
              others_cores(before), options_of_run(command.scene), program_name()});
  if (!advice) return refuse(advice.error());
  const auto chart =
      stiffness_chart(setup->device, setup->haptics.coupling, command.settings.rate_Hz);
  if (!chart) return refuse(chart.error());
  // From here on a signal waits until the files are complete.
  const SignalPhaseScope in_order(SignalPhase::kInOrder);
  if (const auto error = check_output()) return refuse(*error);
  const auto page =
      write_in_place({*advice, effort, results, findings ? &*findings : nullptr, *chart}, *files);
  if (!page) return refuse(page.error());
  if (page->end == PageEnd::kInterrupted) return report_nothing_is_written();
  std::cout << advice_text(*advice) << "\n";
  if (!results.empty()) std::cout << knobs_text(results);
  if (findings) std::cout << scene_text(*findings);
  std::cout << files_text(command, page->end == PageEnd::kMade, findings.has_value());
  std::vector<std::string> warnings =
      scene ? load_warning_lines(*scene) : std::vector<std::string>{};
  return exit_code_after_signals(finish_output(with_page_warnings(std::move(warnings), *page)));
}

class AccuracyCommand final : public Command {
 public:
  CLI::App* add_to(CLI::App& program) override;
  int run(const std::vector<std::string>&) override {
    request_.asks_rate = app_->get_option("--rate")->count() > 0;
    return accuracy(request_);
  }

 private:
  CLI::App* app_ = nullptr;
  AccuracyRequest request_;
};

CLI::App* AccuracyCommand::add_to(CLI::App& program) {
  CLI::App& app = *program.add_subcommand(
      "accuracy",
      "measure what accuracy costs in time, and recommend settings for a device and a scene");
  app_ = &app;
  set_help(app, "  ./run.sh accuracy models/star.glb --quick --knob a4_step --out report\n");
  add_scene(app, request_.scene, false);
  app.add_flag("--quick", request_.quick,
               "measure coarser meshes and shorter paths, within a minute");
  app.add_option("--out", request_.out_dir, "folder for report, tables and diagrams")
      ->capture_default_str();
  app.add_option("--knob", request_.knobs,
                 "measure only this knob, by the name of its diagram; may be repeated")
      ->expected(1)
      ->take_all();
  add_integer(app, "--seed", request_.seed, {}, "seed of poses, paths and noise");
  CLI::Option* scene = app.get_option("SCENE");
  for (const char* name : {"--node", "--scene", "--feel-hidden", "--scale", "--fit", "--pose",
                           "--material", "--max-memory"}) {
    app.get_option(name)->needs(scene)->group(kSceneOptionsGroup);
  }
  RunSettings& run = request_.settings;
  const auto of_scene = [&](const char* name, const std::string& help) {
    add_setting(app, run_setting(name), run, help)->needs(scene)->group(kSceneOptionsGroup);
  };
  of_scene("--rate", "servo rate, Hz; if given, the advice is for this rate");
  of_scene("--stiffness", "coupling spring of surfaces without their own, N/m");
  of_scene("--damping", "coupling damper of surfaces without their own, N s/m");
  of_scene("--radius", help_of(run_setting("--radius")));
  for (const char* name : {"--device-mass", "--device-damping", "--device-friction"}) {
    const RunSetting& setting = run_setting(name);
    add_setting(app, setting, run, help_of(setting))->group(kDeviceGroup);
  }
  add_real(app, "--device-delay", request_.delay_s, kWallDelay_s,
           "longest time from a sample of the device to the force that answers it, s; it lowers "
           "the limits of the stiffness, and the simulated hand does not have it")
      ->group(kDeviceGroup);
  add_real(app, "--encoder-quantum", run.device.encoder_quantum_m, kZeroOrMore,
           "step of the device's encoders, m; 0 for exact positions")
      ->group(kDeviceGroup);
  return &app;
}

}  // namespace

std::unique_ptr<Command> make_accuracy_command() {
  return std::make_unique<AccuracyCommand>();
}

}  // namespace palpate
