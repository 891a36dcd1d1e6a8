#pragma once

// What a user is told about the reading of a trajectory.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/trajectory_columns.h"

namespace palpate {

struct TrajectoryFacts {
  const TrajectoryColumns& columns;
  std::size_t naming_comment = 0;      // line of the comment that names the columns; 0: none
  std::size_t unit_comment = 0;        // line of the comment that states units; 0: none
  std::size_t decimal_comma_line = 0;  // 0: none
  std::optional<double> rate_Hz;
};

// One line for the units that were converted, and one for what was read otherwise than the file
// may mean, such as columns that are not used. Empty for a file of x y z in metres.
std::vector<std::string> trajectory_notes(const TrajectoryFacts& facts);

}  // namespace palpate
