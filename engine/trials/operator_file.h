#pragma once

// Operator files: the ranges from which the parameters of simulated persons are drawn.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/operator_parameters.h"
#include "geometry/base/result.h"

namespace palpate {

// The range of one parameter. The value for a person is low + (high - low) x with a random number
// x, uniform in [0, 1), or high - (high - low) x if the parameter falls.
struct ParameterRange {
  double low = 0.0;
  double high = 0.0;  // >= low; equal: all persons have this value
  bool falls = false;
  std::string draw;    // parameters with the same draw share one random number
  std::string source;  // "choice" if there is none
};

// The name of a parameter of OperatorParameters in operator files, its unit and its valid values.
struct PersonParameter {
  std::string_view name;  // the name of the field
  std::string_view unit;  // "1": dimensionless
  double OperatorParameters::*field;
  double least;  // valid: from least to most; most is far beyond the value of any hand
  double most;
  bool is_least_out;  // the range excludes `least` itself
};
inline constexpr std::size_t kPersonParameterCount = 10;
const std::array<PersonParameter, kPersonParameterCount>& person_parameters();

// An operator file. JSON:
//   {"palpate_operator": 1, "name": "people2005", "version": 1, "note": "...",
//    "parameters": {"sight_delay_s": {"low": 0.1, "high": 0.2, "unit": "s", "source": "choice",
//                                     "draw": "x", "falls": true}, ...}}
// All parameters of OperatorParameters are required. draw (the name of the parameter) and falls
// (false) are optional. Ranges are finite and valid, and the largest gain times the largest delay
// is below pi/2: at and above pi/2 the correction oscillates with growing amplitude.
struct OperatorFile {
  std::string name;
  int version = 1;
  std::string note;
  std::array<ParameterRange, kPersonParameterCount> ranges;  // in the order of person_parameters()
  // OperatorParameters::comfortable_depth_m of all persons. Files do not have it; a sweep sets it.
  double comfortable_depth_m = OperatorParameters{}.comfortable_depth_m;
  std::uint64_t hash = 0;  // of the bytes of the file
};

// The operator files that ship, by name.
inline constexpr std::array<std::string_view, 2> kShippedOperators = {"literature", "people2005"};
// The text of a file that ships; empty for any other name.
std::string_view shipped_operator_text(std::string_view name);

// An error names the element of the file. path: for messages.
Result<OperatorFile> parse_operator(std::string_view text, const std::string& path);

// An error if the largest gain times the largest delay is pi/2 or more. parse_operator() calls it.
std::optional<Error> check_operator(const OperatorFile& file);

// name_or_path: one of kShippedOperators, or the path of a file.
Result<OperatorFile> load_operator(const std::string& name_or_path);

// The parameters of a person. The random number of a draw depends on the seed of the plan, the
// participant, the name of the operator and the name of the draw, and on nothing else: an edited
// range does not change the other parameters.
OperatorParameters draw_person(const OperatorFile& file, std::uint64_t seed, int participant);

}  // namespace palpate
