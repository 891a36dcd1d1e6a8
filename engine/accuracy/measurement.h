#pragma once

// Measures a knob: repeats every level in turn, takes medians and quartiles, and fits orders.
// recommendation.h decides what the figures mean.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/knob.h"

namespace palpate {

// Median and quartiles over the repeats of a level.
struct Spread {
  double low = 0.0;  // first quartile
  double median = 0.0;
  double high = 0.0;  // third quartile

  static Spread of(std::vector<double> values);
};

struct LevelResult {
  double value = 0.0;
  std::string label;
  Spread error;  // at least the floor of its method
  Spread time;
  double raw_error = 0.0;  // the median as measured, possibly below the floor
  double iterations = 0.0;
  std::uint64_t ticks = 0;  // over all repeats
  int repeats = 0;
  int failures = 0;     // repeats that failed
  std::string failure;  // the first failure
  bool at_floor = false;
  bool on_front = false;  // as of judge() in recommendation.h

  // A level counts if no repeat failed.
  bool counts() const { return failures == 0; }
  bool was_measured() const { return repeats > failures; }
};

struct MethodResult {
  std::string name;
  std::vector<LevelResult> levels;
  std::optional<double> expected_order;
  std::optional<double> order;  // as of fitted_order()
  double floor = 0.0;
};

// One level of one method.
struct LevelPlace {
  std::size_t method = 0;
  std::size_t level = 0;

  bool operator==(const LevelPlace&) const = default;
};

struct KnobResult {
  Knob knob;
  std::vector<MethodResult> methods;
  std::array<LevelResult, 3> presets;  // fast, balanced, exact

  // judge() in recommendation.h sets the following.
  std::optional<LevelPlace> recommended;
  // By what factor the best of the clearly better levels is better than the default in time or
  // error; 1 if no level is clearly better.
  double default_behind = 1.0;
  std::string better_than_default;  // that level
  // The title of the knob that Knob::decided_by names, if reconcile() used its recommendation.
  std::string decided_by_title;

  // Neither level nor method is a choice: the knob shows costs alone.
  bool has_choice() const { return !(knob.levels_are_given && knob.methods_are_given); }
  LevelPlace default_place() const { return {knob.default_method, knob.default_level}; }
  bool default_is_on_front() const { return default_behind <= 1.0; }
};

inline constexpr std::array kAccuracyPresets = {Accuracy::fast(), Accuracy::balanced(),
                                                Accuracy::exact()};
inline constexpr std::array<const char*, 3> kPresetNames = {"fast", "balanced", "exact"};
inline constexpr std::size_t kDefaultPreset = 1;

// Called with the share of the work that is done, 0 to 1.
using MeasuringProgress = std::function<void(double)>;

// Repeats levels in turn, so that other work of the machine affects all of them alike. Repeat r of
// every level has the same seed.
KnobResult measure(const Knob& knob, const MeasurementEffort& effort,
                   const MeasuringProgress& progress);

// The seed of a repeat.
std::uint64_t repeat_seed(const MeasurementEffort& effort, int repeat);

// Measures one level alone, for benchmarks.
LevelResult measure_level(const Knob& knob, const LevelPlace& place,
                          const MeasurementEffort& effort);

// Exponent of a power law: least squares of log(error) over log(value), of the levels that count
// and are above the floor. Nothing with fewer than four levels, or where they follow no power law.
std::optional<double> fitted_order(const std::vector<LevelResult>& levels);

}  // namespace palpate
