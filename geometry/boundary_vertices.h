#pragma once

#include <cstdint>
#include <vector>

#include "geometry/surface_mesh.h"

namespace palpate {

// The welded vertices at the ends of welded edges that have one face, in rising order. O(n) in the
// edges of the surface, O(b log b) in those that the split surface has on its boundary.
std::vector<std::uint32_t> boundary_vertices(const SurfaceMesh& mesh);

}  // namespace palpate
