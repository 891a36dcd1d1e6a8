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

struct RunSetting;

// A setting of a run (run_setting.h) that changes while a loop runs. Its unit, range and words and
// its place in HapticSettings are those of that setting. Its value is a number: 0 or 1 for a flag,
// the place of the word for a choice.
struct LiveSetting {
  enum class Kind : std::uint8_t { kFlag, kChoice, kNumber };

  std::uint32_t number;    // of its inputs in recordings: never changed, and never used again
  std::string_view name;   // on the page and in messages
  std::string_view field;  // of the setting of a run
  std::string_view label;
  std::string_view key;  // of the keyboard
  double page_most;      // of a kNumber: the largest that a page may set
  bool is_of_strategy;   // belongs to the strategy of a loop that has one
  // Passes the value in the settings to a loop.
  void (*apply)(HapticLoop& loop, const HapticSettings& settings) noexcept;

  const RunSetting& of_run() const noexcept;
  Kind kind() const noexcept;
  std::span<const std::string_view> words() const noexcept;  // of a kChoice
  // What a page may set.
  double least() const noexcept;
  double most() const noexcept;
  double value(const HapticSettings& settings) const noexcept;
  // x: a value that the setting can have.
  void put(HapticSettings& settings, double x) const noexcept;

  // Whether the number is a flag, the place of a word, or finite.
  bool can_be(double x) const noexcept;
  // Sets the value of a loop. Call on the haptic thread.
  void set(HapticLoop& loop, double x) const noexcept;
};

inline void apply_a4(HapticLoop& loop, const HapticSettings& settings) noexcept {
  loop.set_a4(settings.a4.enabled);
}
inline void apply_force(HapticLoop& loop, const HapticSettings& settings) noexcept {
  loop.set_force(settings.force);
}
inline void apply_coupling(HapticLoop& loop, const HapticSettings& settings) noexcept {
  loop.set_coupling(settings.coupling.stiffness_N_per_m, settings.coupling.damping_Ns_per_m);
}

// One line for each setting. The page lists it, LiveSettings passes it to the haptic thread,
// recordings hold each change of it (InputKind::kSetting), replay makes and ignores these, and the
// page is told the value of the loop. The actuated axes are no number: see InputKind::kActuation.
inline constexpr std::array kLiveSettings = {
    LiveSetting{1, "a4", "a4.enabled", "A4", "a", 0.0, true, apply_a4},
    LiveSetting{2, "force", "force", "force", "f", 0.0, true, apply_force},
    LiveSetting{3, "stiffness", "coupling.stiffness_N_per_m", "stiffness", "k", 5000.0, false,
                apply_coupling},
    LiveSetting{4, "damping", "coupling.damping_Ns_per_m", "damping", "b", 50.0, false,
                apply_coupling},
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
