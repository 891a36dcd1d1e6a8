#include "haptics/strategies/strategy.h"

#include <array>
#include <charconv>
#include <system_error>
#include <utility>

#include "geometry/base/printable.h"
#include "haptics/strategies/haptic_settings.h"

namespace palpate {
namespace {

struct StrategyName {
  StrategyKind kind;
  std::string_view name;
};

constexpr std::string_view kAnisotropicPrefix = "anisotropic:";

constexpr StrategyName kNames[] = {
    {StrategyKind::kNone, "none"},
    {StrategyKind::kMask, "mask"},
    {StrategyKind::kFull, "full"},
    {StrategyKind::kA4, "a4"},
    {StrategyKind::kA4Anticipate, "a4-anticipate"},
    {StrategyKind::kControlDisplay, "cd"},
};

Error error_of(std::string_view name, const std::string& expected, std::string hint = "") {
  constexpr std::size_t kMaxLength = 40;
  return invalid_argument("strategy",
                          "is \"" + printable(name.substr(0, kMaxLength)) +
                              (name.size() > kMaxLength ? "...\"" : "\"") + "; expected " +
                              expected,
                          std::move(hint));
}

Result<Strategy> parse_anisotropic(std::string_view name) {
  std::string_view digits = name.substr(kAnisotropicPrefix.size());
  // from_chars refuses a plus sign.
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0.0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, failed] = std::from_chars(digits.data(), end, value);
  const bool is_in = value >= kLeastAnisotropy && value <= kMostAnisotropy;  // false for NaN
  if (failed == std::errc() && stop == end && is_in) {
    return Strategy{StrategyKind::kAnisotropic, value};
  }
  return error_of(name, "anisotropic:E with a decimal number E from 0.0625 to 16",
                  "E below 1 weakens what the motors cannot push");
}

}  // namespace

Result<Strategy> parse_strategy(std::string_view name) {
  for (const StrategyName& known : kNames) {
    if (known.name == name) return Strategy{known.kind};
  }
  if (name.starts_with(kAnisotropicPrefix)) return parse_anisotropic(name);
  return error_of(name, "one of none, mask, full, a4, a4-anticipate, anisotropic:E, cd",
                  name == "anisotropic" ? "add E, as in anisotropic:0.25" : "");
}

std::string name_of(const Strategy& strategy) {
  for (const StrategyName& known : kNames) {
    if (known.kind == strategy.kind) return std::string(known.name);
  }
  std::array<char, 32> digits;  // the shortest form of a double has at most 24 characters
  const auto [end, failed] =
      std::to_chars(digits.data(), digits.data() + digits.size(), strategy.anisotropy);
  return std::string(kAnisotropicPrefix) + std::string(digits.data(), end);
}

void set_strategy(const Strategy& strategy, HapticSettings& settings) {
  const StrategyKind kind = strategy.kind;
  settings.force = kind == StrategyKind::kNone   ? ForceMode::kNone
                   : kind == StrategyKind::kFull ? ForceMode::kFull
                                                 : ForceMode::kActuated;
  settings.a4.enabled = kind == StrategyKind::kA4 || kind == StrategyKind::kA4Anticipate;
  settings.strategy.reset();
  if (has_own_step(kind)) settings.strategy = strategy;
}

}  // namespace palpate
