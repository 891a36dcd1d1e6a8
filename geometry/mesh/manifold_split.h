#pragma once

// Copies vertices so that a triangle list becomes an oriented 2-manifold with boundary. Keeps every
// face.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"

namespace palpate {

// The copies of vertices and the corners that use the copies. Both are rare.
struct ManifoldSplit {
  struct Corner {
    std::uint32_t corner;  // 3 f + i: corner i of face f
    std::uint32_t vertex;  // split vertex
  };
  std::vector<std::uint32_t> copied_vertices;  // the original vertex of each copy
  std::vector<Corner> corners;                 // corners that use a copy; each once

  // The faces with split vertices; empty if there is no copy.
  std::vector<Triangle> split_faces(std::span<const Triangle> faces) const;
};

// Corners of two faces at a vertex share a split vertex only if a chain of aligned edges at the
// vertex connects them. Every split vertex therefore has one fan of faces, open or closed. Split
// vertex v < vertex_count belongs to the first fan of vertex v; the split vertices of all further
// fans have the next numbers, in order of faces. mates: the mates of these faces' half-edges.
// Requires that each vertex is used by at least one face. Linear time.
//
// The two ends of an open fan may lie on the same welded edge, if a third face was separated from
// this edge. The split surface then has two boundary edges with the same two ends.
ManifoldSplit split_to_manifold(std::span<const Triangle> faces, const HalfEdgeMates& mates,
                                std::size_t vertex_count);

}  // namespace palpate
