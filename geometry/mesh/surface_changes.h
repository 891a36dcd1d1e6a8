#pragma once

// Changes of a welded surface that make parts of its boundary meet. WeldedSurface::change() applies
// them.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// A vertex that gets another position.
struct MovedVertex {
  std::uint32_t vertex;
  Vec3 position_m;
};

// A vertex that is replaced by another one, everywhere.
struct MergedVertex {
  std::uint32_t vertex;
  std::uint32_t into;  // not itself merged into a third vertex
};

// A vertex at which the edge of a half-edge is divided (half_edges.h).
struct EdgeDivision {
  std::uint32_t half_edge;  // without a mate
  std::uint32_t vertex;     // of the surface, or an added one; not merged into another one
  double along;             // place on the edge: 0 at the start of the half-edge, 1 at its end
};

// Vertices and half-edges have the numbers that they have before any of the changes.
struct SurfaceChanges {
  std::vector<MovedVertex> moved;       // each vertex once; ascending
  std::vector<MergedVertex> merged;     // each vertex once; ascending
  std::vector<Vec3> added_m;            // positions of new vertices, numbered after the others
  std::vector<EdgeDivision> divisions;  // ascending by half-edge, then by `along`
  std::size_t joined_edges = 0;         // pairs of boundary edges that become one edge

  bool empty() const { return moved.empty() && merged.empty() && divisions.empty(); }
};

}  // namespace palpate
