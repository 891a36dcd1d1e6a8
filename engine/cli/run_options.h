#pragma once

// The options of a run that the commands `run`, `replay` and `accuracy` share.

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/session/run_setting.h"
#include "geometry/base/result.h"

namespace palpate {

// The values of the options. Options that are numbers or choices are parsed into `settings`. The
// other members hold the text of an option, which make_setup() parses.
struct RunOptions {
  RunSettings settings;
  std::string actuated_axes;       // "0 0 1; 1 0 0", device frame
  std::string place;               // "x y z qw qx qy qz", m: T_device_scene at the start
  std::vector<std::string> moves;  // "NODE=vx vy vz wx wy wz" each: m/s and rad/s, scene axes
  std::vector<std::string> energy_budgets;  // "SOURCE=MJ" or "SOURCE=MJ,W" each
  bool is_quiet = false;              // make_setup() writes no line about a measured work budget
  bool states_quantum = false;        // the help states the encoder quantum of the device
  bool knows_auto_stiffness = false;  // --stiffness may be `auto`, which a device with motors has
  bool has_auto_stiffness = false;    // it is
};

// Adds the options of one group to a command, with their help. The options must outlive the parsing
// of the command line.
void add_settings(CLI::App& app, RunOptions& options, SettingGroup group,
                  RunSettingTable table = run_settings());
// Adds the option of a number, a flag or a choice, which has no group yet.
CLI::Option* add_setting(CLI::App& app, const RunSetting& setting, RunSettings& settings,
                         const std::string& help);
// Adds --cpu, which has no group yet.
CLI::Option* add_cpu(CLI::App& app, std::optional<std::uint64_t>& cpu);
void add_json(CLI::App& app, bool& json);

// Parses the texts and checks that all numbers are finite and in range. An Error names the option,
// or the field of a setting; option_names.h maps such a field to its option.
Result<RunSetup> make_setup(const RunOptions& options);

// Adds an option whose argument is one of a few words, each of which stands for a value that is
// passed to put(). usual: the word for the default; the help shows this word.
template <typename Value, typename Put>
requires std::invocable<Put, Value> CLI::Option* add_choice(
    CLI::App& app, const std::string& name, Put put,
    const std::vector<std::pair<std::string, Value>>& choices, const std::string& usual,
    const std::string& help) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : ",") + choice.first;
  const auto read = [put, choices, name, words](const std::string& text) {
    for (const auto& choice : choices) {
      if (choice.first != text) continue;
      put(choice.second);
      return;
    }
    throw CLI::ValidationError(name, "is \"" + text + "\"; expected one of " + words);
  };
  return app.add_option_function<std::string>(name, read, help)
      ->type_name("TEXT:{" + words + "}")
      ->default_str(usual);
}

// The same; the value is put into a variable.
template <typename Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& value,
                        const std::vector<std::pair<std::string, Value>>& choices,
                        const std::string& usual, const std::string& help) {
  return add_choice<Value>(
      app, name, [&value](const Value& chosen) { value = chosen; }, choices, usual, help);
}

}  // namespace palpate
