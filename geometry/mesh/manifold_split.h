#pragma once

// Copies vertices until a triangle list is an oriented 2-manifold with boundary. No face is lost.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"

namespace palpate {

// The corners that get a vertex of their own. Rare.
struct ManifoldSplit {
  struct Corner {
    std::uint32_t corner;  // 3 f + i: corner i of face f
    std::uint32_t vertex;  // split vertex
  };
  std::vector<std::uint32_t> copied_vertices;  // the original of each split vertex that is a copy
  std::vector<Corner> corners;                 // that have one of those; each once

  // The faces in split vertices; none where all are as they were.
  std::vector<Triangle> split_faces(std::span<const Triangle> faces) const;
};

// Corners of two faces at a vertex stay together only if a chain of aligned edges at that vertex
// joins them, so every split vertex has one fan of faces, open or closed. Split vertex
// v < vertex_count is the first fan of vertex v; further fans come after, in order of faces. mates:
// of these faces, each vertex used by one at least. Linear time.
//
// The two ends of an open fan may lie on one edge, where a third face was cut off. The split
// surface then has two boundary edges with the same two ends.
ManifoldSplit split_to_manifold(std::span<const Triangle> faces, const HalfEdgeMates& mates,
                                std::size_t vertex_count);

}  // namespace palpate
