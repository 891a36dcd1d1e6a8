#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/welded_surface.h"

namespace palpate {

// The vertices at the ends of edges that have one face, in rising order. O(n) in the faces of the
// surface, O(b log b) in its edges that do not have two faces oriented alike. Not after a
// SurfaceMesh has been made of it.
std::vector<std::uint32_t> boundary_vertices(const WeldedSurface& surface);

}  // namespace palpate
