#include "geometry/half_edges.h"

#include <algorithm>
#include <cassert>
#include <span>

namespace palpate {
namespace {

// The half-edges of all edges, grouped by the lower end of the edge. Entries hold the higher end
// and the half-edge, packed to sort fast.
struct EdgeTable {
  std::vector<std::uint32_t> end;  // per lower end: where its entries end; they begin where those
                                   // of the vertex before end
  std::vector<std::uint64_t> entries;

  std::span<std::uint64_t> at_vertex(std::size_t v) {
    const std::size_t begin = v == 0 ? 0 : end[v - 1];
    return std::span(entries).subspan(begin, end[v] - begin);
  }
};

std::uint32_t half_edge_of(std::uint64_t entry) {
  return static_cast<std::uint32_t>(entry);
}

EdgeTable group_by_lower_end(const std::vector<Triangle>& faces, std::size_t vertex_count) {
  EdgeTable table;
  std::vector<std::uint32_t> first(vertex_count + 1, 0);
  for (const Triangle& face : faces) {
    ++first[std::min(face[0], face[1]) + 1];
    ++first[std::min(face[1], face[2]) + 1];
    ++first[std::min(face[2], face[0]) + 1];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) first[v + 1] += first[v];
  table.entries.resize(3 * faces.size());
  std::uint64_t half_edge = 0;
  for (const Triangle& face : faces) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = face[e];
      const std::uint32_t to = face[e == 2 ? 0 : e + 1];
      // Filling moves the start of each group on to its end.
      const std::uint64_t higher = std::max(from, to);
      table.entries[first[std::min(from, to)]++] = higher << 32 | half_edge++;
    }
  }
  table.end = std::move(first);
  return table;
}

class Matcher {
 public:
  Matcher(const std::vector<Triangle>& faces, HalfEdgeMates& mates)
      : faces_(faces), mates_(mates) {}

  // Enters the half-edges of one edge.
  void match_edge(std::span<const std::uint64_t> edge) {
    if (edge.size() == 1) {
      ++mates_.boundary_edges;
    } else if (edge.size() == 2) {
      match_pair(half_edge_of(edge[0]), half_edge_of(edge[1]));
    } else {
      ++mates_.non_manifold_edges;
      look_for_duplicates(edge);
    }
  }

 private:
  std::uint32_t start(std::uint32_t h) const { return faces_[h / 3][h % 3]; }
  // The corner of the face that is not on the edge.
  std::uint32_t apex(std::uint32_t h) const { return start(previous_half_edge(h)); }

  void match_pair(std::uint32_t h, std::uint32_t g) {
    if (apex(h) == apex(g)) mates_.has_duplicates = true;
    if (start(h) != start(g)) {
      mates_.aligned[h] = g;
      mates_.aligned[g] = h;
    } else {
      ++mates_.non_manifold_edges;
      mates_.misaligned.push_back({h, g});
      mates_.misaligned.push_back({g, h});
    }
  }

  void look_for_duplicates(std::span<const std::uint64_t> edge) {
    if (mates_.has_duplicates) return;
    apexes_.clear();
    for (const std::uint64_t entry : edge) apexes_.push_back(apex(half_edge_of(entry)));
    std::sort(apexes_.begin(), apexes_.end());
    mates_.has_duplicates = std::adjacent_find(apexes_.begin(), apexes_.end()) != apexes_.end();
  }

  const std::vector<Triangle>& faces_;
  HalfEdgeMates& mates_;
  std::vector<std::uint32_t> apexes_;
};

}  // namespace

HalfEdgeMates match_half_edges(const std::vector<Triangle>& faces, std::size_t vertex_count) {
  assert(faces.size() < kNoHalfEdge / 3);
  HalfEdgeMates mates;
  mates.aligned.assign(3 * faces.size(), kNoHalfEdge);
  Matcher matcher(faces, mates);
  EdgeTable table = group_by_lower_end(faces, vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const std::span<std::uint64_t> entries = table.at_vertex(v);
    std::sort(entries.begin(), entries.end());
    for (std::size_t begin = 0; begin < entries.size();) {
      std::size_t end = begin + 1;
      while (end < entries.size() && entries[end] >> 32 == entries[begin] >> 32) ++end;
      matcher.match_edge(entries.subspan(begin, end - begin));
      begin = end;
    }
  }
  std::sort(
      mates.misaligned.begin(), mates.misaligned.end(),
      [](const MisalignedMate& x, const MisalignedMate& y) { return x.half_edge < y.half_edge; });
  return mates;
}

}  // namespace palpate
