#pragma once

// Positions that compare equal become one vertex.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

struct Weld {
  std::vector<Vec3> positions_m;         // distinct, in order of first occurrence; no -0
  std::vector<std::uint32_t> vertex_of;  // per position given: index into positions_m
};

// Bytes that this takes for so many positions, beside them.
std::uint64_t weld_memory(std::uint64_t positions);

// Exact: no tolerance, -0 equals +0. Positions: finite, fewer than 2^32 - 1 of them. Expected
// linear time (hashing). Any frame. The same for any number of threads.
Weld weld_equal_positions(std::vector<Vec3> positions_m);

}  // namespace palpate
