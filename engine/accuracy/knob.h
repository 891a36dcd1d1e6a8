#pragma once

// A knob: something that buys accuracy for time. What is turned, what runs at each of its levels,
// and what the error is measured against.
//
// Every run is a closure, so that the report, the benchmarks and the tests measure the same thing.
// Not for the haptic thread; runs may share scenes, so that one thread measures at a time.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptics/proxy/accuracy.h"

namespace palpate {

struct Quantity {
  std::string name;  // "depth error"
  std::string unit;  // "m"; empty for none
};

// One repeat at one level. Both figures are over ticks in contact only.
struct Sample {
  double error = 0.0;        // >= 0, in Knob::error
  double time = 0.0;         // in Knob::time
  double iterations = 0.0;   // of the solver, mean of a tick
  std::uint64_t ticks = 0;   // that were averaged over
  std::string failure = {};  // why this repeat does not count: "unstable: ...", "leaked: ..."
};

struct Level {
  double value;       // in Knob::level; what an order is fitted against
  std::string label;  // as people say it: "1 kHz", "82k triangles"
  // A repeat. The seed decides all that is random in it: pose, path, phase, noise.
  std::function<Sample(std::uint64_t seed)> run;
};

// One curve: levels that differ by Level::value alone.
struct Method {
  std::string name;
  std::vector<Level> levels;  // from coarse to fine
  // d log(error) / d log(level) where theory has one.
  std::optional<double> expected_order = {};
  // Errors below it are not told apart from it: the digits of the format that the levels differ
  // in. Reports show such errors as the floor. In Knob::error; 0 for none.
  double floor = 0.0;
};

struct Knob {
  std::string name;   // of files and rows: "servo_rate"
  std::string title;  // "Servo rate"
  Quantity level;
  Quantity error;
  Quantity time;          // "time of a tick", "ns"; "computing for a second of contact", "us"
  std::string workload;   // what runs, with its K and B, which are the same at all levels
  std::string reference;  // what errors are against
  std::string floor_is;   // what Method::floor is, if any method has one
  std::vector<Method> methods;
  // Levels that nobody chooses (where the mesh is, how fast a hand): then methods are compared
  // level by level, and the front is that of each level.
  bool levels_are_given = false;
  // Methods that nobody chooses (which object it is): then the front is that of each method.
  bool methods_are_given = false;

  // What a program does that says nothing: methods[default_method].levels[default_level].
  std::size_t default_method = 0;
  std::size_t default_level = 0;
  // The same workload there, under a preset.
  std::function<Sample(std::uint64_t seed, const Accuracy& preset)> run_preset;

  // An error that is small enough for a hand, and why. The level recommended is the quickest one
  // with no more.
  double enough = 0.0;
  std::string enough_because;
  // What the default buys that neither error nor time shows; for when it is not on the front.
  std::string default_because;
};

// How much work goes into the ladders.
struct StudyEffort {
  bool quick = false;  // coarser meshes and shorter paths; as many repeats
  std::uint64_t seed = 1;

  static constexpr int kRepeats = 21;  // odd, so that the median is one of them
};

}  // namespace palpate
