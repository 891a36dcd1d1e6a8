#pragma once

// A split surface as an OpenMesh.

#include <cstdint>
#include <vector>

#include "geometry/half_edges.h"
#include "geometry/surface_mesh.h"

namespace palpate {

// Fills an empty surface with the points and connectivity of what split_to_manifold() left: face f
// is face f, starting with the same corner; its vertices are the positions and after those the
// copies, in order. mates: those the split was made with.
//
// Links half-edges directly. add_face() searches all edges of a vertex for each face, which is
// quadratic at the apex of a large fan. Linear time. No normals.
void write_open_mesh(const std::vector<Triangle>& faces, const HalfEdgeMates& mates,
                     const std::vector<Vec3>& positions_m,
                     const std::vector<std::uint32_t>& copied_vertices, OpenMeshSurface& surface);

}  // namespace palpate
