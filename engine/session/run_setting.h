#pragma once

// The settings of a run, one line for each. The options of the command line with their help, the
// keys of plans, the keys of recordings and the table in
// docs/reference/settings.md follow from these lines.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "engine/session/number_range.h"
#include "engine/session/run_setup.h"

namespace palpate {

// Options that commands add together.
enum class SettingGroup : std::uint8_t {
  kScene,
  kDevice,
  kWorkspace,  // of the simulated hand's device
  kMechanics,  // the same
  kMotors,     // of a device with motors in place of the simulated hand
  kTouch,
  kRotation,
  kOutput
};

// A value in HapticSettings, which recordings hold, or elsewhere in RunSettings.
template <class Value>
struct SettingPlace {
  Value& (*in_haptics)(HapticSettings&) = nullptr;
  Value& (*in_run)(RunSettings&) = nullptr;                       // null if in_haptics is not
  const Value& (*read_haptics)(const HapticSettings&) = nullptr;  // with in_haptics

  Value& of(RunSettings& settings) const {
    return in_haptics ? in_haptics(settings.haptics) : in_run(settings);
  }
};

// One of a few words, in HapticSettings.
struct SettingChoice {
  std::span<const std::string_view> words;
  // The place of the word, or the number of words if no word has this value.
  std::size_t (*get)(const HapticSettings&);
  void (*put)(HapticSettings&, std::size_t);
};

// A value that each reader reads in a way of its own.
struct OwnSetting {
  bool is_haptic = false;  // in HapticSettings
};

using SettingValuePlace =
    std::variant<OwnSetting, SettingChoice, SettingPlace<bool>, SettingPlace<double>,
                 SettingPlace<std::optional<double>>, SettingPlace<int>,
                 SettingPlace<std::optional<int>>, SettingPlace<std::int64_t>>;

// The key in the object `device` of a plan. It is optional unless the plan must state it.
struct PlanKey {
  const char* name = nullptr;  // null: plans do not have it
  int turn = 100;              // a lower turn is read and written first
  bool is_required = false;
  std::optional<NumberRange> range = {};  // if it is not that of the option
};

// The key in a recording.
struct RecordedKey {
  const char* name = nullptr;  // null: recordings do not have it
  // All recordings have the keys with a turn; a lower one is read first. Turn 0: recordings of
  // before do not have it, and it is written only if the value is not the default of
  // HapticSettings, so that other recordings keep their keys.
  int turn = 0;
};

struct RunSetting {
  std::string_view field;  // of RunSettings, or of its HapticSettings, as messages name it
  SettingValuePlace value;
  std::string_view option = {};  // of the command line; empty: only recordings have the setting
  SettingGroup group = SettingGroup::kDevice;
  NumberRange range = {};  // of numbers
  // The help of a number that is no whole number states the unit between meaning and note.
  std::string_view meaning = {};
  std::string_view unit = {};
  std::string_view note = {};
  PlanKey plan = {};
  RecordedKey recorded = {};

  bool is_haptic() const;  // in HapticSettings
};

using RunSettingTable = std::span<const RunSetting>;

// In the order of the help.
RunSettingTable run_settings();

// The setting with this option. Requires that it exists.
const RunSetting& run_setting(std::string_view option);

// The setting that changes while a loop runs (live_setting.h) under this number. Requires that it
// exists. Needs no search of the table: the haptic thread may call it.
const RunSetting& run_setting_with(std::uint32_t live_number) noexcept;

// The settings that have a plan key or a recorded key, by turn.
std::vector<const RunSetting*> by_plan_turn(RunSettingTable table);
std::vector<const RunSetting*> by_recorded_turn(RunSettingTable table);

// "stiffness of the coupling for surfaces that state none, N/m"; usual: stands in brackets behind
// the unit, if it is not empty.
std::string help_of(const RunSetting& setting, const std::string& usual = {});

// The error of a number that is not in the range of the setting; that of a plan, if it has one.
std::optional<Error> check_range(const RunSetting& setting, double value);
std::optional<Error> check_range(const RunSetting& setting, int value);

// The function takes settings that may be changed and settings that may not.
template <class Function>
constexpr auto in_haptics(Function) {
  using Value = std::remove_reference_t<std::invoke_result_t<Function, HapticSettings&>>;
  return SettingPlace<Value>{[](HapticSettings& s) -> Value& { return Function()(s); }, nullptr,
                             [](const HapticSettings& s) -> const Value& { return Function()(s); }};
}

template <class Function>
constexpr auto in_run(Function at) {
  using Value = std::remove_reference_t<std::invoke_result_t<Function, RunSettings&>>;
  return SettingPlace<Value>{nullptr, at};
}

// words: by the values of the enumeration, from 0 on.
template <class Function>
constexpr SettingChoice choice_in_haptics(Function, std::span<const std::string_view> words) {
  using Enum = std::remove_reference_t<std::invoke_result_t<Function, HapticSettings&>>;
  return {words, [](const HapticSettings& s) { return static_cast<std::size_t>(Function()(s)); },
          [](HapticSettings& s, std::size_t word) { Function()(s) = static_cast<Enum>(word); }};
}

}  // namespace palpate
