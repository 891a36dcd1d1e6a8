#pragma once

// The connected parts of a surface, and their sizes.

#include <cstdint>
#include <vector>

#include "geometry/base/lowest_union.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {

// The largest extent of the part of each given vertex. Faces that share a vertex are of one part.
// Metres, mesh frame. O(n log n).
std::vector<double> part_extents_m(const WeldedSurface& surface,
                                   const std::vector<std::uint32_t>& vertices);

}  // namespace palpate
