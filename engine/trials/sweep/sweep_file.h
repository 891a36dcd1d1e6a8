#pragma once

// The file of a sweep: what `palpate experiment sweep` reads.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/plan.h"
#include "engine/trials/sweep/sweep_parameter.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr std::size_t kMostLevels = 100;
inline constexpr int kMostSweepPoints = 10'000;  // of both blocks together

// A parameter and its levels, in ascending order; words are in the order of the parameter.
struct SweptParameter {
  std::size_t parameter = 0;  // index of sweep_parameters()
  std::vector<double> levels;
  // The range of the hypercube, of parameters whose levels are not drawn.
  double low = 0.0, high = 0.0;
};

struct SweepHypercube {
  int points = 0;
  std::uint64_t seed = 0;
  int participants = 1;  // of each point
};

// A sweep. Its JSON is an object with these keys:
//   palpate_sweep  1
//   name           text
//   plan           the base plan: an object as in the file of a plan (plan.h)
//   parameters     an object; each key is a name of sweep_parameters(), each value a list of two or
//                  more levels
//   hypercube      {"points": 100, "seed": 23, "participants": 2}
// The base plan has all levels of haptic and rotation, one following and no practice, because every
// point compares the six conditions.
struct Sweep {
  std::string path;  // as the caller named it
  std::string name;
  ExperimentPlan plan;
  std::vector<SweptParameter> parameters;  // in the order of sweep_parameters()
  SweepHypercube hypercube;
  // The hash of the content, without the parts that may differ between machines
  // (ExperimentPlan::canonical), and of the operator `literature`.
  std::uint64_t hash = 0;
};

// An error names the element, such as /plan/device/rate_Hz. path: the path of the file, for
// messages. folder: the folder to which paths in the base plan are relative.
Result<Sweep> parse_sweep(std::string_view text, const std::string& path,
                          const std::string& folder);

// name_or_path: "sweep", the sweep that ships, or the path of a file.
Result<Sweep> load_sweep(const std::string& name_or_path);

}  // namespace palpate
