#pragma once

// A split surface as an OpenMesh.

#include <vector>

#include "geometry/half_edges.h"
#include "geometry/manifold_split.h"
#include "geometry/surface_mesh.h"

namespace palpate {

// Fills an empty surface with the points and connectivity of a split: face f is face f, starting
// with the same corner, vertex v is split vertex v. mates: those the split was made with.
//
// Links half-edges directly. add_face() searches all edges of a vertex for each face, which is
// quadratic at the apex of a large fan. Linear time. No normals.
void write_open_mesh(const ManifoldSplit& split, const HalfEdgeMates& mates,
                     const std::vector<Vec3>& original_positions_m, OpenMeshSurface& surface);

}  // namespace palpate
