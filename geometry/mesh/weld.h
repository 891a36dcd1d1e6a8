#pragma once

// Welds positions that compare equal into one vertex.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

struct Weld {
  std::vector<Vec3> positions_m;         // distinct, in order of first occurrence; no -0
  std::vector<std::uint32_t> vertex_of;  // per input position: index into positions_m
};

// Bytes that weld_equal_positions() needs for this number of positions, in addition to the input.
std::uint64_t weld_memory(std::uint64_t positions);

// Exact: no tolerance, -0 equals +0. Positions: finite, fewer than 2^32 - 1 of them. Expected
// linear time (hashing). Any frame. The result does not depend on the number of threads.
Weld weld_equal_positions(std::vector<Vec3> positions_m);

}  // namespace palpate
