#pragma once

// The points of a sweep: the conditions under which its base plan runs.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/plan.h"
#include "engine/trials/sweep/sweep_file.h"
#include "engine/trials/sweep/sweep_parameter.h"
#include "geometry/base/result.h"

namespace palpate {

enum class SweepBlock : std::uint8_t {
  kBase,        // the base plan
  kOneAtATime,  // the base plan with another value of one parameter
  kHypercube    // all parameters of the sweep drawn at once
};
inline constexpr std::array<std::string_view, 3> kSweepBlockNames = {"base", "one_at_a_time",
                                                                     "hypercube"};

struct SweepPoint {
  SweepBlock block = SweepBlock::kBase;
  std::optional<std::size_t> varied;  // the parameter, of kOneAtATime
  SweepValues values;
  int participants = 1;
};

// The base point, then one point for each level of each parameter that the base plan does not have
// already, then the points of the hypercube (latin_hypercube.h; a dimension has the name of its
// parameter).
std::vector<SweepPoint> sweep_points(const Sweep& sweep);

// The plan that runs at a point. All points share the seed of the base plan, and so their persons
// and random numbers, apart from what the point sets.
ExperimentPlan plan_at(const Sweep& sweep, const SweepPoint& point);

// An error of the plan at a point, as an error of the sweep: names the parameters that the point
// sets.
Error at_point(Error error, const Sweep& sweep, const SweepPoint& point);

}  // namespace palpate
