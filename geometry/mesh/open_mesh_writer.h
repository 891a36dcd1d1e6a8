#pragma once

// Writes a split surface into an OpenMesh.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/fixed_array.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Fills an empty surface. Face f of the surface is faces[f], starting with the same corner. faces:
// indices of split vertices, each with one fan of faces (manifold_split.h). mates: the mate of each
// half-edge, kNoHalfEdge at the boundary. points: the positions of the vertices; their memory is
// moved, not copied.
//
// The function links half-edges directly. OpenMesh's add_face() searches all edges of a vertex for
// each face, so that its time is quadratic at the apex of a large fan. Linear time. Computes no
// normals.
void write_open_mesh(std::span<const Triangle> faces, FixedArray<std::uint32_t> mates,
                     std::vector<Vec3> points, OpenMeshSurface& surface);

}  // namespace palpate
