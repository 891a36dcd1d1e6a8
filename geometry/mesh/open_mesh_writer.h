#pragma once

// A split surface as an OpenMesh.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/fixed_array.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Fills an empty surface: face f is face f, starting with the same corner. faces: in vertices that
// have one fan of faces each (manifold_split.h). mates: of their half-edges, kNoHalfEdge at the
// boundary. points: of the vertices; they stay where they are in memory.
//
// Links half-edges directly. add_face() searches all edges of a vertex for each face, which is
// quadratic at the apex of a large fan. Linear time. No normals.
void write_open_mesh(std::span<const Triangle> faces, FixedArray<std::uint32_t> mates,
                     std::vector<Vec3> points, OpenMeshSurface& surface);

}  // namespace palpate
