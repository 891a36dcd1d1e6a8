#pragma once

// The settings of a haptic loop that change while it runs.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "engine/session/tick_sink.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// A setting as a number: 0 or 1 for a flag, the place of the word for a choice.
struct LiveSetting {
  enum class Kind : std::uint8_t { kFlag, kChoice, kNumber };

  std::uint32_t number;   // of its inputs in recordings: never changed, and never used again
  std::string_view name;  // on the page and in messages
  std::string_view label;
  std::string_view key;  // of the keyboard
  Kind kind;
  std::string_view unit;
  double most;                                // of a kNumber that a page may set; the least is 0
  std::span<const std::string_view> choices;  // of a kChoice
  bool is_of_strategy;                        // belongs to the strategy of a loop that has one
  double (*value)(const HapticSettings& settings) noexcept;
  void (*put)(HapticSettings& settings, double value) noexcept;
  // Passes the value in the settings to a loop.
  void (*apply)(HapticLoop& loop, const HapticSettings& settings) noexcept;

  // Whether the number is a flag, the place of a choice, or finite.
  bool can_be(double value) const noexcept;
  // Sets the value of a loop. Call on the haptic thread.
  void set(HapticLoop& loop, double value) const noexcept;
};

inline constexpr std::array<std::string_view, 3> kForceModeNames = {"none", "actuated", "full"};

// One line for each setting. The page lists it, LiveSettings passes it to the haptic thread,
// recordings hold each change of it (InputKind::kSetting), replay makes and ignores these, and the
// page is told the value of the loop. The actuated axes are no number: see InputKind::kActuation.
inline constexpr std::array kLiveSettings = {
    LiveSetting{
        1,
        "a4",
        "A4",
        "a",
        LiveSetting::Kind::kFlag,
        "",
        1.0,
        {},
        true,
        [](const HapticSettings& s) noexcept { return s.a4.enabled ? 1.0 : 0.0; },
        [](HapticSettings& s, double value) noexcept { s.a4.enabled = value != 0.0; },
        [](HapticLoop& loop, const HapticSettings& s) noexcept { loop.set_a4(s.a4.enabled); }},
    LiveSetting{
        2, "force", "force", "f", LiveSetting::Kind::kChoice, "", 2.0, kForceModeNames, true,
        [](const HapticSettings& s) noexcept { return static_cast<double>(s.force); },
        [](HapticSettings& s, double value) noexcept {
          s.force = static_cast<ForceMode>(static_cast<int>(value));
        },
        [](HapticLoop& loop, const HapticSettings& s) noexcept { loop.set_force(s.force); }},
    LiveSetting{
        3,
        "stiffness",
        "stiffness",
        "k",
        LiveSetting::Kind::kNumber,
        "N/m",
        5000.0,
        {},
        false,
        [](const HapticSettings& s) noexcept { return s.coupling.stiffness_N_per_m; },
        [](HapticSettings& s, double value) noexcept { s.coupling.stiffness_N_per_m = value; },
        [](HapticLoop& loop, const HapticSettings& s) noexcept {
          loop.set_coupling(s.coupling.stiffness_N_per_m, s.coupling.damping_Ns_per_m);
        }},
    LiveSetting{
        4,
        "damping",
        "damping",
        "b",
        LiveSetting::Kind::kNumber,
        "N s/m",
        50.0,
        {},
        false,
        [](const HapticSettings& s) noexcept { return s.coupling.damping_Ns_per_m; },
        [](HapticSettings& s, double value) noexcept { s.coupling.damping_Ns_per_m = value; },
        [](HapticLoop& loop, const HapticSettings& s) noexcept {
          loop.set_coupling(s.coupling.stiffness_N_per_m, s.coupling.damping_Ns_per_m);
        }},
};

// The place of a setting in the table. A name that it does not have does not compile.
consteval std::size_t live_setting(std::string_view name) {
  std::size_t i = 0;
  while (kLiveSettings[i].name != name) ++i;
  return i;
}

// A new value of the setting at this place of the table.
struct LiveChange {
  std::size_t setting;
  double value;
};

// The changes that an input makes: one, or two of a recording before InputKind::kSetting.
class LiveChanges {
 public:
  // input: with the bytes that kInputKinds states for its kind. Empty: it is no change of a
  // setting, or of a setting that this version does not have, or the setting cannot have the value.
  explicit LiveChanges(const TickInput& input) noexcept;
  std::span<const LiveChange> all() const noexcept { return std::span(changes_).first(count_); }

 private:
  void add(std::size_t setting, double value) noexcept;

  std::array<LiveChange, 2> changes_{};
  std::size_t count_ = 0;
};

}  // namespace palpate
