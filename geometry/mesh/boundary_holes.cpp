#include "geometry/mesh/boundary_holes.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace palpate {
namespace {

// The vertices around a hole: a closed chain; the first one is the lowest.
using Hole = std::vector<std::uint32_t>;

bool counts_as_one(JoinedBoundary& boundary, const Hole& hole) {
  return std::all_of(hole.begin(), hole.end(),
                     [&](std::uint32_t v) { return boundary.counts_as_one(v, hole.front()); });
}

// is_joined: per edge; a whole edge is joined if all its pieces are.
std::vector<Hole> find_holes(JoinedBoundary& boundary, std::span<const BoundaryEdge> whole_edges,
                             const std::vector<bool>& is_joined) {
  constexpr std::uint32_t kNone = JoinedBoundary::kNone;
  std::vector<std::uint32_t> next(boundary.size(), kNone);  // by set: along a tiny edge
  std::vector<std::uint8_t> edges_out(boundary.size(), 0), edges_in(boundary.size(), 0);
  const auto count = [](std::uint8_t& n) { n = std::min<std::uint8_t>(n + 1, 2); };
  for (std::uint32_t e = 0; e < whole_edges.size(); ++e) {
    if (is_joined[e]) continue;
    const BoundaryEdge& edge = whole_edges[e];
    const std::uint32_t from = boundary.lowest(edge.from), to = boundary.lowest(edge.to);
    count(edges_out[from]);
    count(edges_in[to]);
    if (boundary.is_tiny(edge)) next[from] = to;
  }
  std::vector<Hole> holes;
  std::vector<bool> is_done(boundary.size(), false);
  for (std::uint32_t v = 0; v < boundary.size(); ++v) {
    Hole hole;
    std::uint32_t w = v;
    while (w != kNone && !is_done[w] && next[w] != kNone) {
      is_done[w] = true;
      const bool is_plain = edges_out[w] == 1 && edges_in[w] == 1;
      hole.push_back(w);
      w = is_plain ? next[w] : kNone;
    }
    // Two edges between the same two vertices surround no hole.
    if (w == v && hole.size() > 2 && counts_as_one(boundary, hole)) holes.push_back(hole);
  }
  return holes;
}

// Per hole: whether it has a vertex that does not count as one with the lowest, or a face has all
// its corners there.
std::vector<bool> wrong_holes(JoinedBoundary& boundary, const std::vector<Hole>& holes) {
  constexpr std::uint32_t kNone = JoinedBoundary::kNone;
  std::vector<std::uint32_t> hole_of(boundary.size(), kNone);  // by set
  for (std::uint32_t i = 0; i < holes.size(); ++i) {
    for (const std::uint32_t v : holes[i]) hole_of[v] = i;
  }
  const auto hole_at = [&](std::uint32_t v) {
    return v == kNone ? kNone : hole_of[boundary.set_of(v)];
  };
  std::vector<bool> is_wrong(holes.size(), false);
  for (std::uint32_t v = 0; v < boundary.size(); ++v) {
    const std::uint32_t hole = hole_at(v);
    if (hole == kNone) continue;
    if (!boundary.counted_as_one(v, holes[hole].front())) is_wrong[hole] = true;
  }
  for (const std::uint32_t f : boundary.faces()) {
    const Triangle face = boundary.corners_of(f);
    const std::uint32_t hole = hole_at(face[0]);
    if (hole != kNone && hole == hole_at(face[1]) && hole == hole_at(face[2])) {
      is_wrong[hole] = true;
    }
  }
  return is_wrong;
}

}  // namespace

std::size_t close_holes(JoinedBoundary& boundary, std::span<const BoundaryEdge> edges,
                        std::size_t whole_count, std::vector<bool> is_joined) {
  const auto pieces = edges.subspan(whole_count);
  for (const BoundaryEdge& piece : pieces) is_joined[piece.whole] = true;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (!is_joined[whole_count + i]) is_joined[pieces[i].whole] = false;
  }
  const std::vector<Hole> holes = find_holes(boundary, edges.first(whole_count), is_joined);
  if (holes.empty()) return 0;
  const std::vector<bool> is_wrong = wrong_holes(boundary, holes);
  std::size_t open_edges = 0;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    if (is_wrong[i]) {
      open_edges += holes[i].size();
      continue;
    }
    for (const std::uint32_t v : holes[i]) boundary.unite(v, holes[i].front());
  }
  return open_edges;
}

}  // namespace palpate
