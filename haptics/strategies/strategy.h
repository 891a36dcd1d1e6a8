#pragma once

// Strategies: the techniques that render a contact on a device with missing motors.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

class ActuationModel;
class StrategyStep;
struct ContactWorld;
struct HapticSettings;

// The part of the force that the loop commands. The mode does not affect the rotation by A4.
enum class ForceMode : std::uint8_t {
  kNone,
  kActuated,  // projected on the actuated axes
  kFull       // not projected, as if every axis had an actuator
};

// The number that a strategy takes after its name and a colon.
struct StrategyParameter {
  std::string_view symbol;  // as in help: "E"
  double least = 0.0;
  double most = 0.0;
  double example = 0.0;
  std::string_view meaning;  // of its values, in one line
  // What the name alone stands for. No value: the name needs a number.
  std::optional<double> value_of_name_alone = {};

  constexpr bool allows(double value) const { return value >= least && value <= most; }
};

// A strategy as the program knows it: a row of strategies(). Its formulas, its source and what it
// does not promise are in the header of the same name.
struct StrategyType {
  std::string_view name;
  ForceMode force = ForceMode::kActuated;
  bool has_a4 = false;
  std::optional<StrategyParameter> parameter = {};
  // Makes what the strategy does in a tick beyond force and A4. Null: nothing.
  std::unique_ptr<StrategyStep> (*make_step)(const ActuationModel& actuation,
                                             const HapticSettings& settings) = nullptr;
  // Refuses worlds and settings that are beyond the strategy. Null: there are none.
  std::optional<Error> (*check)(const ContactWorld& world,
                                const HapticSettings& settings) = nullptr;
};

// The strategies that force and A4 describe: no force; the force, projected on the actuated axes;
// the force as if every axis had a motor, which is a reference; the projected force while A4 turns
// the scene in contact.
inline constexpr StrategyType kNoForceStrategy{.name = "none", .force = ForceMode::kNone};
inline constexpr StrategyType kMaskStrategy{.name = "mask"};
inline constexpr StrategyType kFullStrategy{.name = "full", .force = ForceMode::kFull};
inline constexpr StrategyType kA4Strategy{.name = "a4", .has_a4 = true};

// All strategies, in the order in which texts list them.
std::span<const StrategyType* const> strategies() noexcept;

// A strategy with its parameter. Thread-safety: a value.
struct Strategy {
  const StrategyType* type = &kMaskStrategy;  // never null
  double parameter = 0.0;                     // of a type with a parameter; otherwise 0

  bool operator==(const Strategy&) const = default;
};

// Reads the name of a strategy; a type with a parameter has the name NAME:NUMBER, and the number is
// read alike in every locale. NAME alone is read where its type states a value for it. An Error has
// the element "strategy".
Result<Strategy> parse_strategy(std::string_view name);

// The name that parse_strategy() reads as this strategy, with the shortest number that gives the
// same bits. The number is always there: the value of a name alone may change with a version.
std::string name_of(const Strategy& strategy);

// NAME:E for a type with a parameter E, NAME[:E] if it may be left out, otherwise NAME.
std::string name_with_symbol(const StrategyType& type);

// The names of all strategies for a help text: "none, ..., anisotropic:E with E from 0.0625 to 16,
// or cd".
std::string strategy_names_for_help();

// Sets the part of the force that is commanded, A4, and what a strategy beyond these two needs
// (HapticSettings::strategy). The strategies that force and A4 describe leave the same settings as
// these.
void set_strategy(const Strategy& strategy, HapticSettings& settings);

}  // namespace palpate
