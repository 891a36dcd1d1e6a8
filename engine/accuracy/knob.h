#pragma once

// A knob: a parameter that buys accuracy with time. It states the levels of the parameter, the run
// at each level, and the reference of the errors.
//
// Every run is a closure, so that the report, the benchmarks and the tests measure the same code.
// Not for the haptic thread; runs may share scenes, so only one thread may measure at a time.

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
  std::string unit;  // "m"; empty for a number without a unit
};

// One repeat at one level. Error and time are taken over the ticks in contact only.
struct Sample {
  double error = 0.0;        // >= 0, in Knob::error
  double time = 0.0;         // in Knob::time
  double iterations = 0.0;   // of the solver, mean per tick
  std::uint64_t ticks = 0;   // number of ticks in contact
  std::string failure = {};  // why this repeat does not count: "unstable: ...", "leaked: ..."
};

struct Level {
  double value;       // in Knob::level; orders are fitted against it
  std::string label;  // for readers: "1 kHz", "82k triangles"
  // Runs one repeat. The seed determines every random choice: pose, path, phase, noise.
  std::function<Sample(std::uint64_t seed)> run;
};

// One curve: levels that differ in Level::value alone.
struct Method {
  std::string name;
  std::vector<Level> levels;  // from coarse to fine
  // d log(error) / d log(level), if theory has an order.
  std::optional<double> expected_order = {};
  // Errors below the floor cannot be distinguished from it, because the number format has no more
  // digits. Reports show them as the floor. In Knob::error; 0 for no floor.
  double floor = 0.0;
};

struct Knob {
  std::string name;   // of files and rows: "servo_rate"
  std::string title;  // "Servo rate"
  Quantity level;
  Quantity error;
  Quantity time;          // "time of a tick", "ns"; "computing for a second of contact", "us"
  std::string workload;   // the run, with its K and B, which are the same at all levels
  std::string reference;  // the truth that errors are measured against
  std::string floor_is;   // the origin of Method::floor, if a method has one
  std::vector<Method> methods;
  // The user cannot choose the level (position of the mesh, speed of the hand). Methods are then
  // compared level by level, and each level has a Pareto front of its own.
  bool levels_are_given = false;
  // The user cannot choose the method (which object it is). Each method then has a Pareto front of
  // its own.
  bool methods_are_given = false;

  // The default of the program: methods[default_method].levels[default_level].
  std::size_t default_method = 0;
  std::size_t default_level = 0;
  // The default's workload under a preset.
  std::function<Sample(std::uint64_t seed, const Accuracy& preset)> run_preset;

  // An error that is small enough for a hand, and the reason. recommendation.h uses it.
  double enough = 0.0;
  std::string enough_because;
  // An advantage of the default that neither error nor time shows; reported when the default is not
  // on the front.
  std::string default_because;
  // The name of the knob whose recommendation holds for this knob as well, because this knob
  // measures only a part of the error. Both have the same methods and levels. Empty for none.
  std::string decided_by;
};

// How much work each measurement does.
struct MeasurementEffort {
  bool quick = false;  // coarser meshes and shorter paths; the number of repeats stays
  std::uint64_t seed = 1;

  static constexpr int kRepeats = 21;  // odd, so that the median is one of the repeats
};

// A depth error that is small enough for a hand.
inline constexpr double kEnoughDepth_m = 10e-6;
inline constexpr const char* kEnoughDepthBecause =
    "10 µm is a force of 10 mN at 1000 N/m, about the smallest that a hand notices";

}  // namespace palpate
