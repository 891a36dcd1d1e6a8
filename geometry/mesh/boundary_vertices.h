#pragma once

#include <cstdint>
#include <vector>

#include "geometry/mesh/welded_surface.h"

namespace palpate {

// The half-edges of boundary edges (edges with one face), in ascending order. O(n) in the number of
// faces, and O(b log b) in the number of edges without two faces oriented alike. Must not be called
// after a SurfaceMesh has been constructed from the surface.
std::vector<std::uint32_t> boundary_half_edges(const WeldedSurface& surface);

// The vertices at the ends of boundary edges (edges with one face), in ascending order. O(n) in the
// number of faces, and O(b log b) in the number of edges without two faces oriented alike. Must not
// be called after a SurfaceMesh has been constructed from the surface.
std::vector<std::uint32_t> boundary_vertices(const WeldedSurface& surface);

}  // namespace palpate
