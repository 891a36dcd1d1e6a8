#include "geometry/mesh/closed_parts.h"

#include <algorithm>

#include "geometry/base/lowest_union.h"

namespace palpate {
namespace {

struct FaceEdge {
  std::uint32_t low, high;  // vertices
  std::uint32_t face;

  bool is_same(const FaceEdge& other) const { return low == other.low && high == other.high; }
};

std::vector<FaceEdge> sorted_edges(std::span<const Triangle> faces) {
  std::vector<FaceEdge> edges;
  edges.reserve(3 * faces.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = faces[f][k], b = faces[f][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), f});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const FaceEdge& a, const FaceEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  return edges;
}

}  // namespace

ClosedParts closed_parts(std::span<const Triangle> faces) {
  const std::vector<FaceEdge> edges = sorted_edges(faces);
  LowestUnion parts(faces.size());
  std::vector<std::uint32_t> odd_faces;  // a face of each edge that has an odd number of them
  for (auto edge = edges.begin(); edge != edges.end();) {
    auto next = edge + 1;
    for (; next != edges.end() && next->is_same(*edge); ++next) parts.unite(edge->face, next->face);
    if ((next - edge) % 2 != 0) odd_faces.push_back(edge->face);
    edge = next;
  }
  std::vector<bool> is_open(faces.size());  // by the lowest face of the part
  for (const std::uint32_t face : odd_faces) is_open[parts.lowest(face)] = true;
  ClosedParts closed;
  closed.part_of_face.assign(faces.size(), ClosedParts::kOpen);
  bool is_whole = true;
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const std::uint32_t lowest = parts.lowest(f);
    is_whole = is_whole && lowest == 0 && !is_open[0];
    if (is_open[lowest]) continue;
    closed.part_of_face[f] =
        lowest == f ? static_cast<std::uint32_t>(closed.count++) : closed.part_of_face[lowest];
  }
  if (is_whole || closed.count == 0) closed.part_of_face = {};
  return closed;
}

}  // namespace palpate
