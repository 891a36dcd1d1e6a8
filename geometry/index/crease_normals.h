#pragma once

// Normals that vary smoothly over a surface except across its sharp edges: for force shading.

#include <array>
#include <vector>

#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Unit normals at the corners of one face, in the order a, b, c of the TriangleGeometry that a
// SurfaceIndex keeps for it. That is the order of SurfaceMesh::face(), but under a mirroring map
// the index exchanges b and c, and so does this.
using CornerNormals = std::array<std::array<float, 3>, 3>;

// Of every face of the mesh, in the frame of the index that SurfaceIndex(mesh, map) is:
// normals[index.face(slot)] belongs to index.triangle(slot).
//
// The normal at a corner is the mean of those of the faces around the vertex that can be reached
// from its face without crossing a crease, each weighted by its angle there (G. Thuermer and C. A.
// Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998): how a face is cut into
// triangles does not matter. Where the faces cancel down to rounding, it is that of the face
// itself.
//
// A crease is an edge where the normals of its two faces, mapped, are more than crease_angle_rad
// apart (as with OpenMesh's find_feature_edges(); 0 to pi, what lies outside is clamped), a
// boundary edge, and one where three faces or more meet. A face turned over among its neighbours
// makes none: the others count for it with their normals reversed, and it for them.
//
// Load time only: it allocates, less than 100 bytes a face besides the result. O(n), apart from the
// search for neighbours across edges that surface() cuts. Thread-safe.
std::vector<CornerNormals> crease_normals(const SurfaceMesh& mesh, const AffineMap& map,
                                          double crease_angle_rad);

}  // namespace palpate
