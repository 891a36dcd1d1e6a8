#include "geometry/half_edges.h"

#include <algorithm>
#include <cassert>

#include "geometry/buckets.h"

namespace palpate {
namespace {

struct Ends {
  std::uint32_t from;
  std::uint32_t to;
};

Ends ends(const std::vector<Triangle>& faces, std::size_t half_edge) {
  const Triangle& face = faces[half_edge / 3];
  const std::size_t e = half_edge % 3;
  return {face[e], face[e == 2 ? 0 : e + 1]};
}

// Enters the half-edges of one edge.
void match_edge(const std::vector<Triangle>& faces, const std::uint64_t* begin,
                const std::uint64_t* end, HalfEdgeMates& mates) {
  if (end - begin == 1) {
    ++mates.boundary_edges;
    return;
  }
  if (end - begin > 2) {
    ++mates.non_manifold_edges;
    return;
  }
  const auto h = static_cast<std::uint32_t>(begin[0]);
  const auto g = static_cast<std::uint32_t>(begin[1]);
  mates.any[h] = g;
  mates.any[g] = h;
  if (ends(faces, h).from == ends(faces, g).to) {
    mates.aligned[h] = g;
    mates.aligned[g] = h;
  } else {
    ++mates.non_manifold_edges;
  }
}

}  // namespace

HalfEdgeMates match_half_edges(const std::vector<Triangle>& faces, std::size_t vertex_count) {
  assert(faces.size() < kNoHalfEdge / 3);
  const std::size_t half_edge_count = 3 * faces.size();
  HalfEdgeMates mates;
  mates.any.assign(half_edge_count, kNoHalfEdge);
  mates.aligned.assign(half_edge_count, kNoHalfEdge);
  const Buckets by_lower = group_by_key(half_edge_count, vertex_count, [&](std::size_t h) {
    return std::min(ends(faces, h).from, ends(faces, h).to);
  });
  std::vector<std::uint64_t> at_vertex;  // (higher end, half-edge), packed to sort fast
  for (std::size_t v = 0; v < vertex_count; ++v) {
    at_vertex.clear();
    for (std::uint32_t i = by_lower.first[v]; i < by_lower.first[v + 1]; ++i) {
      const std::uint32_t h = by_lower.items[i];
      const std::uint64_t higher = std::max(ends(faces, h).from, ends(faces, h).to);
      at_vertex.push_back(higher << 32 | h);
    }
    std::sort(at_vertex.begin(), at_vertex.end());
    const std::uint64_t* const end = at_vertex.data() + at_vertex.size();
    for (const std::uint64_t* edge = at_vertex.data(); edge != end;) {
      const std::uint64_t* edge_end = edge + 1;
      while (edge_end != end && *edge_end >> 32 == *edge >> 32) ++edge_end;
      match_edge(faces, edge, edge_end, mates);
      edge = edge_end;
    }
  }
  return mates;
}

}  // namespace palpate
