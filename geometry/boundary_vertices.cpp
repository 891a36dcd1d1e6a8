#include "geometry/boundary_vertices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace palpate {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // welded vertices, the lower one first

// A welded edge for every half-edge that has no neighbour in the split surface: where the surface
// was cut because three faces meet, or two that are misoriented, an edge is there once for each.
std::vector<Edge> cut_or_open_edges(const SurfaceMesh& mesh) {
  const OpenMeshSurface& surface = mesh.surface();
  const auto welded = [&](OpenMesh::VertexHandle v) {
    return mesh.welded_vertex(static_cast<std::size_t>(v.idx()));
  };
  std::vector<Edge> edges;
  for (std::size_t e = 0; e < surface.n_edges(); ++e) {
    const OpenMesh::EdgeHandle edge(static_cast<int>(e));
    if (!surface.is_boundary(edge)) continue;
    const OpenMesh::HalfedgeHandle h = surface.halfedge_handle(edge, 0);
    edges.push_back(
        std::minmax({welded(surface.from_vertex_handle(h)), welded(surface.to_vertex_handle(h))}));
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

std::vector<std::uint32_t> boundary_vertices(const SurfaceMesh& mesh) {
  std::vector<std::uint32_t> vertices;
  if (mesh.report().boundary_edges == 0) return vertices;
  const std::vector<Edge> edges = cut_or_open_edges(mesh);
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
