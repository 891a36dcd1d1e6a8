#pragma once

// Copies vertices until a triangle list is an oriented 2-manifold with boundary. No face is lost.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/half_edges.h"
#include "geometry/types.h"

namespace palpate {

// Puts the faces in split vertices. Corners of two faces at a vertex stay together only if a chain
// of aligned edges at that vertex joins them, so every split vertex has one fan of faces, open or
// closed. Split vertex v < vertex_count is the first fan of vertex v; further fans come after, in
// order of faces. Returns the original vertex of each of those. mates: of these faces, each vertex
// used by one at least. Linear time.
//
// The two ends of an open fan may lie on one edge, where a third face was cut off. The split
// surface then has two boundary edges with the same two ends.
std::vector<std::uint32_t> split_to_manifold(std::vector<Triangle>& faces,
                                             const HalfEdgeMates& mates, std::size_t vertex_count);

}  // namespace palpate
