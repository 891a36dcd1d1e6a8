#include "engine/cli/run_options.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "engine/cli/command_help.h"
#include "engine/cli/number_option.h"
#include "engine/cli/setting_texts.h"

namespace palpate {
namespace {

const char* heading(SettingGroup group) {
  switch (group) {
    case SettingGroup::kScene:
      return kSceneGroup;
    case SettingGroup::kDevice:
    case SettingGroup::kWorkspace:
    case SettingGroup::kMechanics:
      return kDeviceGroup;
    case SettingGroup::kMotors:
      return kMotorGroup;
    case SettingGroup::kTouch:
      return kTouchGroup;
    case SettingGroup::kRotation:
      return kA4Group;
    case SettingGroup::kOutput:
      return kOutputGroup;
  }
  return "";
}

IntegerRange whole(const NumberRange& range) {
  return {static_cast<std::uint64_t>(range.least), static_cast<std::uint64_t>(range.most)};
}

// Adds an option by the kind of its value.
struct OptionAdder {
  CLI::App& app;
  const RunSetting& setting;
  RunSettings& settings;
  const std::string& help;

  std::string name() const { return std::string(setting.option); }

  CLI::Option* operator()(const OwnSetting&) const { return nullptr; }
  CLI::Option* operator()(const SettingPlace<bool>& at) const {
    return app.add_flag(name(), at.of(settings), help);
  }
  CLI::Option* operator()(const SettingPlace<double>& at) const {
    return add_real(app, name(), at.of(settings), setting.range, help);
  }
  CLI::Option* operator()(const SettingPlace<std::optional<double>>& at) const {
    return add_real(app, name(), at.of(settings), setting.range, help);
  }
  template <class Whole>
  CLI::Option* operator()(const SettingPlace<Whole>& at) const {
    return add_integer(app, name(), at.of(settings), whole(setting.range), help);
  }
  CLI::Option* operator()(const SettingChoice& choice) const {
    std::vector<std::pair<std::string, std::size_t>> words;
    for (const std::string_view word : choice.words) words.emplace_back(word, words.size());
    const std::string usual = words.at(choice.get(settings.haptics)).first;
    const auto put = [&haptics = settings.haptics, choice](std::size_t word) {
      choice.put(haptics, word);
    };
    return add_choice<std::size_t>(app, name(), put, words, usual, help);
  }
};

// The help states what is used without the option.
std::string usual_text(const RunSetting& setting, const RunOptions& options) {
  std::ostringstream text;
  if (setting.option == "--actuators") {
    text << options.settings.default_actuators << ", at most the number of sensors";
  }
  if (setting.option == "--encoder-quantum" && options.states_quantum) {
    text << options.settings.device.encoder_quantum_m;
  }
  return text.str();
}

CLI::Option* add_work_budget(CLI::App& app, RunSettings& settings, const std::string& help) {
  const auto read = [&settings](const std::string& text) {
    settings.measures_work_budget = text == "auto";
    settings.work_budget.reset();
    if (settings.measures_work_budget) return;
    const auto units =
        parse_integer("--work-budget", text, whole(run_setting("--work-budget").range));
    if (!units) throw CLI::ValidationError("--work-budget", units.error().problem);
    settings.work_budget = static_cast<std::int64_t>(*units);
  };
  return app.add_option_function<std::string>("--work-budget", read, help)
      ->type_name("INTEGER|auto");
}

// A number, or `auto`, with which the number stays as it is.
CLI::Option* add_stiffness(CLI::App& app, RunOptions& options, const std::string& help) {
  double& stiffness = options.settings.haptics.coupling.stiffness_N_per_m;
  const auto read = [&options, &stiffness](const std::string& text) {
    options.has_auto_stiffness = text == "auto";
    if (options.has_auto_stiffness) return;
    const auto number = parse_real("--stiffness", text, run_setting("--stiffness").range);
    if (!number) throw CLI::ValidationError("--stiffness", number.error().problem);
    stiffness = *number;
  };
  std::ostringstream usual;
  usual << stiffness << ", with --device auto";
  return app
      .add_option_function<std::string>(
          "--stiffness", read,
          help + "; auto: half of the largest that is stable on the device of --device")
      ->type_name("NUMBER|auto")
      ->default_str(usual.str());
}

CLI::Option* add_workspace(CLI::App& app, DeviceDescription& device, const std::string& help) {
  const auto read = [&device](const std::string& text) {
    const auto extent_m = parse_real("--workspace", text, run_setting("--workspace").range);
    if (!extent_m) throw CLI::ValidationError("--workspace", extent_m.error().problem);
    set_workspace_extent(device, *extent_m);
  };
  std::ostringstream usual;
  usual << workspace_extent_m(device);
  return app.add_option_function<std::string>("--workspace", read, help)
      ->type_name("NUMBER")
      ->default_str(usual.str());
}

// Adds the option of an OwnSetting.
CLI::Option* add_own(CLI::App& app, const RunSetting& setting, RunOptions& options,
                     const std::string& help) {
  const std::string name(setting.option);
  if (name == "--work-budget") return add_work_budget(app, options.settings, help);
  if (name == "--workspace") return add_workspace(app, options.settings.device, help);
  if (name == "--move") {
    return app.add_option(name, options.moves, help)->expected(1)->take_all();
  }
  if (name == "--energy-budget") {
    return app.add_option(name, options.energy_budgets, help)
        ->expected(1)
        ->take_all()
        ->type_name("BUDGET");
  }
  return app.add_option(name, name == "--place" ? options.place : options.actuated_axes, help);
}

CLI::Option* add_option(CLI::App& app, const RunSetting& setting, RunOptions& options,
                        const std::string& help) {
  if (std::holds_alternative<OwnSetting>(setting.value)) {
    return add_own(app, setting, options, help);
  }
  if (options.knows_auto_stiffness && setting.option == "--stiffness") {
    return add_stiffness(app, options, help);
  }
  return add_setting(app, setting, options.settings, help);
}

}  // namespace

CLI::Option* add_setting(CLI::App& app, const RunSetting& setting, RunSettings& settings,
                         const std::string& help) {
  return std::visit(OptionAdder{app, setting, settings, help}, setting.value);
}

void add_settings(CLI::App& app, RunOptions& options, SettingGroup group, RunSettingTable table) {
  for (const RunSetting& setting : table) {
    if (setting.group != group || setting.option.empty()) continue;
    const std::string help = help_of(setting, usual_text(setting, options));
    add_option(app, setting, options, help)->group(heading(group));
  }
}

CLI::Option* add_cpu(CLI::App& app, std::optional<std::uint64_t>& cpu) {
  constexpr std::uint64_t kMostCpu = 1023;
  return add_integer(app, "--cpu", cpu, {0, kMostCpu}, "the CPU on which the haptic thread stays");
}

void add_json(CLI::App& app, bool& json) {
  app.add_flag("--json", json, "print the results as JSON")->group(kOutputGroup);
}

Result<RunSetup> make_setup(const RunOptions& options) {
  RunSettings settings = options.settings;
  auto axes = parse_axes(options.actuated_axes);
  if (!axes) return axes.error();
  settings.actuated_axes = std::move(*axes);
  auto place = parse_place(options.place);
  if (!place) return place.error();
  settings.haptics.initial_pose = *place;
  auto budgets = parse_energy_budgets(options.energy_budgets);
  if (!budgets) return budgets.error();
  settings.energy_budgets = *budgets;
  auto moves = parse_moves(options.moves);
  if (!moves) return moves.error();
  settings.moves = std::move(*moves);
  auto setup = make_setup(settings);
  if (setup && setup->measured_budget && !options.is_quiet) {
    std::cerr << "palpate: work budget: " << setup->measured_budget->units
              << " units a tick; a unit took " << std::lround(setup->measured_budget->unit_ns)
              << " ns\n";
  }
  return setup;
}

}  // namespace palpate
