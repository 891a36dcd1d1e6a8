#include "geometry/mesh/boundary_vertices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace palpate {
namespace {

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;  // vertices, the lower one first

// One edge for every half-edge without an aligned mate. An edge with three faces, or with two
// misaligned faces, is listed once for each face.
std::vector<VertexPair> unmatched_edges(const WeldedSurface& surface) {
  std::vector<VertexPair> edges;
  for (std::uint32_t h = 0; h < surface.mates().aligned.size(); ++h) {
    if (surface.mates().aligned[h] != kNoHalfEdge) continue;
    const Triangle& face = surface.faces()[h / 3];
    edges.push_back(std::minmax(face[h % 3], face[next_half_edge(h) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

std::vector<std::uint32_t> boundary_vertices(const WeldedSurface& surface) {
  std::vector<std::uint32_t> vertices;
  if (surface.report().boundary_edges == 0) return vertices;
  const std::vector<VertexPair> edges = unmatched_edges(surface);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_alone =
        (i == 0 || edges[i - 1] != edges[i]) && (i + 1 == edges.size() || edges[i + 1] != edges[i]);
    if (is_alone) vertices.insert(vertices.end(), {edges[i].first, edges[i].second});
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace palpate
