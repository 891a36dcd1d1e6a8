#include "geometry/mesh/boundary_vertices.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace palpate {
namespace {

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;  // vertices, the lower one first

VertexPair ends_of(const WeldedSurface& surface, std::uint32_t h) {
  const Triangle& face = surface.faces()[h / 3];
  return std::minmax({face[h % 3], face[next_half_edge(h) % 3]});
}

// An edge with three faces, or with two misaligned faces, has several half-edges without a mate.
void drop_edges_of_several_faces(const WeldedSurface& surface,
                                 std::vector<std::uint32_t>& half_edges) {
  std::vector<std::pair<VertexPair, std::uint32_t>> edges;
  edges.reserve(half_edges.size());
  for (const std::uint32_t h : half_edges) edges.emplace_back(ends_of(surface, h), h);
  std::sort(edges.begin(), edges.end());
  half_edges.clear();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_alone = (i == 0 || edges[i - 1].first != edges[i].first) &&
                          (i + 1 == edges.size() || edges[i + 1].first != edges[i].first);
    if (is_alone) half_edges.push_back(edges[i].second);
  }
  std::sort(half_edges.begin(), half_edges.end());
}

}  // namespace

std::vector<std::uint32_t> boundary_half_edges(const WeldedSurface& surface) {
  std::vector<std::uint32_t> half_edges;
  if (surface.report().boundary_edges == 0) return half_edges;
  for (std::uint32_t h = 0; h < surface.mates().aligned.size(); ++h) {
    if (surface.mates().aligned[h] == kNoHalfEdge) half_edges.push_back(h);
  }
  if (surface.report().non_manifold_edges > 0) drop_edges_of_several_faces(surface, half_edges);
  return half_edges;
}

std::vector<std::uint32_t> boundary_vertices(const WeldedSurface& surface) {
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t h : boundary_half_edges(surface)) {
    const auto [a, b] = ends_of(surface, h);
    vertices.insert(vertices.end(), {a, b});
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace palpate
