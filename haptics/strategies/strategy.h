#pragma once

// Strategies: the techniques that render a contact on a device with missing motors.

#include <cstdint>
#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

struct HapticSettings;

enum class StrategyKind : std::uint8_t {
  kNone,           // no force
  kMask,           // the force, projected on the actuated axes
  kFull,           // the force as if every axis had a motor: a reference
  kA4,             // kMask, and A4 turns the scene in contact
  kA4Anticipate,   // kA4, and the scene may turn before the touch (a4_anticipate.h)
  kAnisotropic,    // the proxy rests in the norm of W (anisotropic.h)
  kControlDisplay  // the scene follows a part of the hand's motion (control_display.h)
};

// Whether the ticks of a strategy differ from all ticks that ForceMode and A4 give.
inline constexpr bool has_own_step(StrategyKind kind) {
  return kind == StrategyKind::kA4Anticipate || kind == StrategyKind::kAnisotropic ||
         kind == StrategyKind::kControlDisplay;
}

// The range of Strategy::anisotropy.
inline constexpr double kLeastAnisotropy = 1.0 / 16;
inline constexpr double kMostAnisotropy = 16.0;

// Thread-safety: a value.
struct Strategy {
  StrategyKind kind = StrategyKind::kMask;
  double anisotropy = 1.0;  // E, kAnisotropic only

  bool operator==(const Strategy&) const = default;
};

// Reads none, mask, full, a4, a4-anticipate, anisotropic:E or cd. E is a decimal number from
// kLeastAnisotropy to kMostAnisotropy, and is read alike in every locale. An Error has the element
// "strategy".
Result<Strategy> parse_strategy(std::string_view name);

// The name that parse_strategy() reads as this strategy, with the shortest E that gives the same
// bits.
std::string name_of(const Strategy& strategy);

// Sets the part of the force that is commanded, A4, and what a strategy beyond these two needs
// (HapticSettings::strategy). The four strategies that force and A4 describe leave the same
// settings as these.
void set_strategy(const Strategy& strategy, HapticSettings& settings);

}  // namespace palpate
