#pragma once

// A knob: a parameter with which accuracy is gained at the cost of time. A Knob states the levels
// of the parameter, the run at each level, and the reference against which errors are measured.
//
// Every run is a closure, so that the report, the benchmarks and the tests measure the same code.
// Not for the haptic thread. Only one thread may measure at a time, because runs may share scenes.

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
  double error = 0.0;        // >= 0, in the unit of Knob::error
  double time = 0.0;         // in the unit of Knob::time
  double iterations = 0.0;   // of the solver, mean per tick
  std::uint64_t ticks = 0;   // number of ticks in contact
  std::string failure = {};  // why this repeat does not count: "unstable: ...", "leaked: ..."
};

struct Level {
  double value;       // in the unit of Knob::level; orders are fitted against it
  std::string label;  // for readers: "1 kHz", "82k triangles"
  // Runs one repeat. The seed determines every random choice: pose, path, phase, noise.
  std::function<Sample(std::uint64_t seed)> run;
};

// One curve of a diagram: levels that differ only in Level::value.
struct Method {
  std::string name;
  std::vector<Level> levels;  // from coarse to fine
  // d log(error) / d log(level), if theory predicts an order of convergence.
  std::optional<double> expected_order = {};
  // Errors below the floor cannot be distinguished from each other, because the number format has
  // no more digits. Reports show the floor in their place. In the unit of Knob::error; 0 for no
  // floor.
  double floor = 0.0;
};

struct Knob {
  std::string name;   // name in files and rows: "servo_rate"
  std::string title;  // "Servo rate"
  Quantity level;
  Quantity error;
  Quantity time;          // "time of a tick", "ns"; "computing for a second of contact", "us"
  std::string workload;   // the run, with its K and B, which are the same at all levels
  std::string reference;  // the exact result, against which errors are measured
  std::string floor_is;   // the origin of Method::floor, if a method has one
  std::vector<Method> methods;
  // True if the user cannot choose the level (position of the mesh, speed of the hand). Methods are
  // then compared level by level, and each level has its own Pareto front.
  bool levels_are_given = false;
  // True if the user cannot choose the method (the object that is touched). Each method then has
  // its own Pareto front.
  bool methods_are_given = false;

  // The default of the program: methods[default_method].levels[default_level].
  std::size_t default_method = 0;
  std::size_t default_level = 0;
  // Runs the workload of the default under a preset.
  std::function<Sample(std::uint64_t seed, const Accuracy& preset)> run_preset;

  // An error that is small enough for a hand, and the reason for this value. recommendation.h uses
  // this error.
  double enough = 0.0;
  std::string enough_because;
  // An advantage of the default that neither error nor time shows; reported if the default is not
  // on the Pareto front.
  std::string default_because;
  // The name of another knob, whose recommendation holds for this knob as well, because this knob
  // measures only a part of the error. Both knobs have the same methods and levels. Empty if there
  // is no such knob.
  std::string decided_by;
};

// The amount of work of each measurement.
struct MeasurementEffort {
  bool quick = false;  // coarser meshes and shorter paths, but the same number of repeats
  std::uint64_t seed = 1;

  static constexpr int kRepeats = 21;  // odd, so that the median is one of the repeats
};

// A depth error that is small enough for a hand.
inline constexpr double kEnoughDepth_m = 10e-6;
inline constexpr const char* kEnoughDepthBecause =
    "10 µm is a force of 10 mN at 1000 N/m, about the smallest that a hand notices";

}  // namespace palpate
