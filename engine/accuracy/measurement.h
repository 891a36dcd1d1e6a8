#pragma once

// Measures a knob: repeats every level in turn, takes medians and spreads, fits orders, finds the
// Pareto front, and says what the presets and the default amount to.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/knob.h"

namespace palpate {

// Of the repeats at one level.
struct Spread {
  double low = 0.0;  // first quartile
  double median = 0.0;
  double high = 0.0;  // third quartile

  static Spread of(std::vector<double> values);
};

struct LevelResult {
  double value = 0.0;
  std::string label;
  Spread error;  // no less than the floor of its method
  Spread time;
  double raw_error = 0.0;  // the median as measured
  double iterations = 0.0;
  std::uint64_t ticks = 0;  // of all repeats
  int repeats = 0;
  int failures = 0;     // repeats that do not count
  std::string failure;  // of the first of them
  bool at_floor = false;
  bool on_front = false;

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
};

struct KnobResult {
  Knob knob;
  std::vector<MethodResult> methods;
  std::array<LevelResult, 3> presets;  // fast, balanced, exact
  std::optional<LevelPlace> recommended;
  // The largest factor by which a level that is better than the default in time or in error, and
  // worse in neither, is better; 1 on the front.
  double default_behind = 1.0;
  std::string better_than_default;  // that level

  LevelPlace default_place() const { return {knob.default_method, knob.default_level}; }
  bool default_is_near_front() const { return default_behind <= kNearFront; }
  static constexpr double kNearFront = 1.1;
};

inline constexpr std::array kAccuracyPresets = {Accuracy::fast(), Accuracy::balanced(),
                                                Accuracy::exact()};
inline constexpr std::array<const char*, 3> kPresetNames = {"fast", "balanced", "exact"};

// Called with the share that is done.
using MeasuringProgress = std::function<void(double)>;

// Levels are repeated in turn, so that what the machine does meanwhile hits all of them alike.
// Repeat r of every level has the same seed.
KnobResult measure(const Knob& knob, const StudyEffort& effort, const MeasuringProgress& progress);

// The seed of a repeat.
std::uint64_t repeat_seed(const StudyEffort& effort, int repeat);

// One level alone, for benchmarks.
LevelResult measure_level(const Knob& knob, const LevelPlace& place, const StudyEffort& effort);

// Least squares of log(error) over log(value), of levels that count and are above the floor; none
// with fewer than four, or where they are on no line.
std::optional<double> fitted_order(const std::vector<LevelResult>& levels);

}  // namespace palpate
