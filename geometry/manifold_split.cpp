#include "geometry/manifold_split.h"

#include <numeric>

namespace palpate {
namespace {

// The corner at the same vertex in the next face, counter-clockwise and clockwise seen from the
// front, or kNoHalfEdge. An aligned mate of the half-edge into a vertex starts there.
std::uint32_t counter_clockwise(const HalfEdgeMates& mates, std::uint32_t corner) {
  return mates.aligned[previous_half_edge(corner)];
}

std::uint32_t clockwise(const HalfEdgeMates& mates, std::uint32_t corner) {
  const std::uint32_t mate = mates.aligned[corner];
  return mate == kNoHalfEdge ? kNoHalfEdge : next_half_edge(mate);
}

// Makes `vertex` the vertex of every corner in the fan of `start`.
void assign_fan(const HalfEdgeMates& mates, std::uint32_t start, std::uint32_t vertex,
                std::vector<Triangle>& faces) {
  std::uint32_t corner = start;
  do {
    faces[corner / 3][corner % 3] = vertex;
    corner = counter_clockwise(mates, corner);
  } while (corner != kNoHalfEdge && corner != start);
  if (corner == start) return;
  corner = clockwise(mates, start);
  for (; corner != kNoHalfEdge; corner = clockwise(mates, corner)) {
    faces[corner / 3][corner % 3] = vertex;
  }
}

}  // namespace

ManifoldSplit split_to_manifold(const std::vector<Triangle>& faces, const HalfEdgeMates& mates,
                                std::size_t vertex_count) {
  constexpr std::uint32_t kUnassigned = 0xffffffffu;
  ManifoldSplit split;
  split.faces.assign(faces.size(), Triangle{kUnassigned, kUnassigned, kUnassigned});
  split.original_vertex.resize(vertex_count);
  std::iota(split.original_vertex.begin(), split.original_vertex.end(), 0u);
  std::vector<bool> has_fan(vertex_count, false);
  for (std::uint32_t corner = 0; corner < 3 * faces.size(); ++corner) {
    if (split.faces[corner / 3][corner % 3] != kUnassigned) continue;
    const std::uint32_t original = faces[corner / 3][corner % 3];
    std::uint32_t vertex = original;
    if (has_fan[original]) {
      vertex = static_cast<std::uint32_t>(split.original_vertex.size());
      split.original_vertex.push_back(original);
    }
    has_fan[original] = true;
    assign_fan(mates, corner, vertex, split.faces);
  }
  return split;
}

}  // namespace palpate
