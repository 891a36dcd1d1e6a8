#pragma once

// Normals for force shading, which vary smoothly over a surface except across its sharp edges.

#include <array>
#include <vector>

#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Unit normals at the corners of one face, in the order a, b, c of the face's TriangleGeometry in a
// SurfaceIndex. This is the order of SurfaceMesh::face(), except that a mirroring map exchanges b
// and c.
using CornerNormals = std::array<std::array<float, 3>, 3>;

// Returns the corner normals of every face, in the index frame of SurfaceIndex(mesh, map):
// normals[index.face(slot)] belongs to index.triangle(slot).
//
// The normal at a corner is a weighted mean of face normals. The mean includes the faces around the
// vertex that are connected to the corner's face without a crease between them. The weights are the
// faces' angles at the vertex (G. Thuermer and C. A. Wuethrich, "Computing Vertex Normals from
// Polygonal Facets", 1998), so that the result does not depend on the triangulation of a polygon.
// If the weighted normals cancel to within rounding, the face's own normal is used.
//
// An edge is a crease in three cases: if the angle between the mapped normals of its two faces
// exceeds crease_angle_rad, if the edge is a boundary edge, or if three or more faces meet at the
// edge. crease_angle_rad is clamped to 0 .. pi and is used as in OpenMesh's find_feature_edges(). A
// face whose orientation is opposite to that of its neighbours does not cause a crease: the mean at
// a neighbour's corner uses the reversed normal of this face, and vice versa.
//
// Load time only: allocates less than 100 bytes per face in addition to the result. O(n), except
// for the search for neighbours across edges that SurfaceMesh::surface() cuts. Thread-safe.
std::vector<CornerNormals> crease_normals(const SurfaceMesh& mesh, const AffineMap& map,
                                          double crease_angle_rad);

}  // namespace palpate
