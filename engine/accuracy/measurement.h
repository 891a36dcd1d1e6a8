#pragma once

// Measures a knob: repeats every level in turn, computes medians and quartiles, and fits orders of
// convergence. recommendation.h judges these results.

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
  std::uint64_t ticks = 0;  // in all repeats together
  int repeats = 0;
  int failures = 0;     // repeats that failed
  std::string failure;  // the first failure
  bool at_floor = false;
  bool on_front = false;  // on the Pareto front; judge() in recommendation.h sets it

  // A level counts if no repeat failed.
  bool counts() const { return failures == 0; }
  bool was_measured() const { return repeats > failures; }
};

struct MethodResult {
  std::string name;
  std::vector<LevelResult> levels;
  std::optional<double> expected_order;
  std::optional<double> order;  // fitted_order() of the levels
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

  // judge() in recommendation.h sets the following members. reconcile() may replace `recommended`
  // and sets decided_by_title.
  std::optional<LevelPlace> recommended;
  // The level that would be recommended, if the spread of the repeats is wider than its effect.
  std::optional<LevelPlace> undecided;
  // Some levels may be clearly better than the default. default_behind is the factor, in time or in
  // error, by which the best of them is better than the default; 1 if no level is clearly better.
  double default_behind = 1.0;
  std::string better_than_default;  // name of the best of those levels
  // The title of the knob that Knob::decided_by names, if reconcile() used its recommendation.
  std::string decided_by_title;

  // False if the user can choose neither the level nor the method. The knob then only shows costs.
  bool has_choice() const { return !(knob.levels_are_given && knob.methods_are_given); }
  LevelPlace default_place() const { return {knob.default_method, knob.default_level}; }
  bool default_is_on_front() const { return default_behind <= 1.0; }
};

inline constexpr std::array kAccuracyPresets = {Accuracy::fast(), Accuracy::balanced(),
                                                Accuracy::exact()};
inline constexpr std::array<const char*, 3> kPresetNames = {"fast", "balanced", "exact"};
inline constexpr std::size_t kDefaultPreset = 1;

// Called with the completed fraction of the work, 0 to 1.
using MeasuringProgress = std::function<void(double)>;

// Measures a knob. Repeats the levels in turn, so that other work of the machine affects all levels
// alike. Repeat r of every level has the same seed.
KnobResult measure(const Knob& knob, const MeasurementEffort& effort,
                   const MeasuringProgress& progress);

// The seed of a repeat.
std::uint64_t repeat_seed(const MeasurementEffort& effort, int repeat);

// Measures one level alone, for benchmarks.
LevelResult measure_level(const Knob& knob, const LevelPlace& place,
                          const MeasurementEffort& effort);

// The exponent of the power law of error and value: a least-squares fit of log(error) over
// log(value), for the levels that count and are above the floor. No value if there are fewer than
// four such levels or if they do not follow a power law.
std::optional<double> fitted_order(const std::vector<LevelResult>& levels);

}  // namespace palpate
