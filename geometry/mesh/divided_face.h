#pragma once

// Divides a triangle at points on its edges.

#include <array>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/source_triangles.h"
#include "geometry/mesh/surface_changes.h"

namespace palpate {

// A part of a triangle.
struct TrianglePart {
  Triangle vertices;
  std::array<CornerWeights, 3> corners;  // the vertices in the frame of the whole's source triangle
};

// Divides a triangle into one more part than there are divisions, so that each part has the
// orientation of the whole, and each division is a corner of the parts beside it. No part has three
// corners on one edge of the whole. divisions: of the half-edges of the triangle's face, ascending
// by half-edge and `along`.
std::vector<TrianglePart> divided(const TrianglePart& whole,
                                  std::span<const EdgeDivision> divisions);

}  // namespace palpate
