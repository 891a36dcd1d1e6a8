#pragma once

// Finds the boundary vertices that lie on boundary edges. Private to find_boundary_joins().

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/joined_boundary.h"

namespace palpate {

struct VertexOnEdge {
  std::uint32_t edge;    // index into the edges
  std::uint32_t vertex;  // index into the boundary vertices: the lowest of its set
  double along;          // place on the edge: 0 at its start, 1 at its end
};

struct VerticesOnEdges {
  std::vector<VertexOnEdge> places;  // edge by edge, and in their order on each edge
  std::size_t ambiguous_edges = 0;   // left out, since the order of their vertices is not certain
  std::size_t capped_edges = 0;      // those of them that were not examined completely
  std::size_t examined_leaves = 0;   // of the tree of vertices
};

// The ends of the chosen edges that lie on other ones of them. chosen: indices into the edges,
// ascending. Deterministic. O(n log n): work is limited per edge.
VerticesOnEdges find_vertices_on_edges(JoinedBoundary& boundary,
                                       std::span<const BoundaryEdge> edges,
                                       const std::vector<std::uint32_t>& chosen);

}  // namespace palpate
