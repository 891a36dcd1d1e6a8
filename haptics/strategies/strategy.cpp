#include "haptics/strategies/strategy.h"

#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "geometry/base/printable.h"
#include "haptics/strategies/a4_anticipate.h"
#include "haptics/strategies/a4_passive.h"
#include "haptics/strategies/anisotropic.h"
#include "haptics/strategies/control_display.h"

namespace palpate {
namespace {

constexpr const StrategyType* kStrategies[] = {
    &kNoForceStrategy,      &kMaskStrategy,      &kFullStrategy,        &kA4Strategy,
    &kA4AnticipateStrategy, &kA4PassiveStrategy, &kAnisotropicStrategy, &kControlDisplayStrategy};

std::string shortest(double value) {
  std::array<char, 32> digits;  // the shortest form of a double has at most 24 characters
  const auto [end, failed] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return std::string(digits.data(), end);
}

std::string range_of(const StrategyParameter& parameter) {
  return std::string(parameter.symbol) + " from " + shortest(parameter.least) + " to " +
         shortest(parameter.most);
}

Error error_of(std::string_view name, const std::string& expected, std::string hint = "") {
  constexpr std::size_t kMaxLength = 40;
  return invalid_argument("strategy",
                          "is \"" + printable(name.substr(0, kMaxLength)) +
                              (name.size() > kMaxLength ? "...\"" : "\"") + "; expected " +
                              expected,
                          std::move(hint));
}

// name: of this type, up to a colon.
Result<Strategy> parse_parameter(const StrategyType& type, std::string_view name) {
  std::string_view digits = name.substr(type.name.size() + 1);
  // from_chars refuses a plus sign.
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0.0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, failed] = std::from_chars(digits.data(), end, value);
  const StrategyParameter& parameter = *type.parameter;
  if (failed == std::errc() && stop == end && parameter.allows(value)) {
    return Strategy{&type, value};
  }
  return error_of(name, name_with_symbol(type) + " with a decimal number " + range_of(parameter),
                  std::string(parameter.meaning));
}

}  // namespace

std::span<const StrategyType* const> strategies() noexcept {
  return kStrategies;
}

Result<Strategy> parse_strategy(std::string_view name) {
  const std::size_t colon = name.find(':');
  std::string all;
  std::string hint;
  for (const StrategyType* type : kStrategies) {
    if (type->parameter && colon != name.npos && type->name == name.substr(0, colon)) {
      return parse_parameter(*type, name);
    }
    if (type->name == name) {
      if (!type->parameter) return Strategy{type};
      if (const auto& value = type->parameter->value_of_name_alone) return Strategy{type, *value};
      hint = "add " + std::string(type->parameter->symbol) + ", as in " +
             name_of({type, type->parameter->example});
    }
    all += (all.empty() ? "" : ", ") + name_with_symbol(*type);
  }
  return error_of(name, "one of " + all, hint);
}

std::string name_of(const Strategy& strategy) {
  std::string name(strategy.type->name);
  if (strategy.type->parameter) name += ":" + shortest(strategy.parameter);
  return name;
}

std::string name_with_symbol(const StrategyType& type) {
  std::string name(type.name);
  if (!type.parameter) return name;
  const std::string number = ":" + std::string(type.parameter->symbol);
  return name + (type.parameter->value_of_name_alone ? "[" + number + "]" : number);
}

std::string strategy_names_for_help() {
  std::string text;
  for (const StrategyType* type : kStrategies) {
    if (!text.empty()) text += type == *std::rbegin(kStrategies) ? ", or " : ", ";
    text += name_with_symbol(*type);
    if (type->parameter) text += " with " + range_of(*type->parameter);
  }
  return text;
}

void set_strategy(const Strategy& strategy, HapticSettings& settings) {
  settings.force = strategy.type->force;
  settings.a4.enabled = strategy.type->has_a4;
  settings.strategy.reset();
  if (strategy.type->make_step) settings.strategy = strategy;
}

}  // namespace palpate
