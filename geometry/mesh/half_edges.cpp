#include "geometry/mesh/half_edges.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "geometry/base/parallel.h"

namespace palpate {
namespace {

constexpr std::size_t kMatchingWorthAThread = 10000;  // faces: a millisecond of work

// The vertices in [begin, end).
struct VertexRange {
  std::uint32_t begin;
  std::uint32_t end;
  bool contains(std::uint32_t v) const { return v - begin < end - begin; }
};

// The start and end vertices of a half-edge.
std::pair<std::uint32_t, std::uint32_t> ends_of(std::span<const Triangle> faces, std::uint32_t h) {
  const Triangle& face = faces[h / 3];
  return {face[h % 3], face[next_half_edge(h) % 3]};
}

// The half-edges whose edge has its lower end in a range, grouped by this end.
class EdgeTable {
 public:
  EdgeTable(std::span<const Triangle> faces, VertexRange range)
      : range_(range), end_(range.end - range.begin + std::size_t{1}, 0) {
    for_each_edge(faces,
                  [&](std::uint32_t lower, std::uint32_t) { ++end_[lower - range_.begin + 1]; });
    for (std::size_t v = 1; v < end_.size(); ++v) end_[v] += end_[v - 1];
    half_edges_ = FixedArray<std::uint32_t>(end_.back());
    for_each_edge(faces, [&](std::uint32_t lower, std::uint32_t half_edge) {
      // Filling advances the start of each group to its end.
      half_edges_[end_[lower - range_.begin]++] = half_edge;
    });
  }

  // The half-edges of vertex number v in the range, ascending.
  std::span<const std::uint32_t> at_vertex(std::size_t v) const {
    const std::size_t begin = v == 0 ? 0 : end_[v - 1];
    return half_edges_.span().subspan(begin, end_[v] - begin);
  }

 private:
  template <typename Visit>
  void for_each_edge(std::span<const Triangle> faces, const Visit& visit) const {
    std::uint32_t half_edge = 0;
    for (const Triangle& face : faces) {
      for (std::size_t e = 0; e < 3; ++e, ++half_edge) {
        const std::uint32_t lower = std::min(face[e], face[e == 2 ? 0 : e + 1]);
        if (range_.contains(lower)) visit(lower, half_edge);
      }
    }
  }

  VertexRange range_;
  std::vector<std::uint32_t> end_;  // per lower end: where its half-edges end; they begin where
                                    // those of the vertex before end
  FixedArray<std::uint32_t> half_edges_;
};

// Divides the vertices into ranges with about the same number of edges each, counted by lower ends
// in a sample.
std::vector<VertexRange> balanced_ranges(std::span<const Triangle> faces, std::size_t vertex_count,
                                         std::size_t count) {
  constexpr std::size_t kSamples = 4096;
  std::vector<std::uint32_t> lower_ends;
  for (std::size_t f = 0; f < faces.size(); f += faces.size() / kSamples + 1) {
    const auto [a, b, c] = faces[f];
    for (const std::uint32_t lower : {std::min(a, b), std::min(b, c), std::min(c, a)}) {
      lower_ends.push_back(lower);
    }
  }
  std::sort(lower_ends.begin(), lower_ends.end());
  std::vector<VertexRange> ranges;
  std::uint32_t begin = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    const std::uint32_t end = i == count ? static_cast<std::uint32_t>(vertex_count)
                                         : lower_ends[lower_ends.size() * i / count];
    ranges.push_back({begin, end});
    begin = end;
  }
  return ranges;
}

// Matches the half-edges of edges whose lower ends are in a range.
class Matcher {
 public:
  Matcher(std::span<const Triangle> faces, FixedArray<std::uint32_t>& aligned)
      : faces_(faces), aligned_(aligned) {}

  EdgeFindings match(VertexRange range) {
    const EdgeTable table(faces_, range);
    for (std::size_t v = 0; v < range.end - range.begin; ++v) {
      entries_.clear();
      for (const std::uint32_t h : table.at_vertex(v)) {
        const auto [from, to] = ends_of(faces_, h);
        entries_.push_back(std::uint64_t{std::max(from, to)} << 32 | h);
      }
      std::sort(entries_.begin(), entries_.end());
      for (auto begin = entries_.begin(); begin != entries_.end();) {
        auto end = begin + 1;
        while (end != entries_.end() && *end >> 32 == *begin >> 32) ++end;
        match_edge({begin, end});
        begin = end;
      }
    }
    return std::move(found_);
  }

 private:
  static std::uint32_t half_edge_of(std::uint64_t entry) {
    return static_cast<std::uint32_t>(entry);
  }

  // Matches the half-edges of one edge.
  void match_edge(std::span<const std::uint64_t> edge) {
    if (edge.size() == 1) {
      ++found_.boundary_edges;
    } else if (edge.size() == 2) {
      match_pair(half_edge_of(edge[0]), half_edge_of(edge[1]));
    } else {
      ++found_.non_manifold_edges;
      look_for_duplicates(edge);
    }
  }

  std::uint32_t start(std::uint32_t h) const { return faces_[h / 3][h % 3]; }
  // The corner of the face that is not on the edge.
  std::uint32_t apex(std::uint32_t h) const { return start(previous_half_edge(h)); }

  void match_pair(std::uint32_t h, std::uint32_t g) {
    if (apex(h) == apex(g)) found_.has_duplicates = true;
    if (start(h) != start(g)) {
      aligned_[h] = g;
      aligned_[g] = h;
    } else {
      ++found_.non_manifold_edges;
      found_.misaligned.push_back({h, g});
      found_.misaligned.push_back({g, h});
    }
  }

  void look_for_duplicates(std::span<const std::uint64_t> edge) {
    if (found_.has_duplicates) return;
    apexes_.clear();
    for (const std::uint64_t entry : edge) apexes_.push_back(apex(half_edge_of(entry)));
    std::sort(apexes_.begin(), apexes_.end());
    found_.has_duplicates = std::adjacent_find(apexes_.begin(), apexes_.end()) != apexes_.end();
  }

  std::span<const Triangle> faces_;
  FixedArray<std::uint32_t>& aligned_;
  EdgeFindings found_;
  std::vector<std::uint64_t> entries_;  // of a vertex: the higher end of an edge and a half-edge
  std::vector<std::uint32_t> apexes_;   // of an edge
};

void add(const EdgeFindings& found, EdgeFindings& all) {
  all.misaligned.insert(all.misaligned.end(), found.misaligned.begin(), found.misaligned.end());
  all.boundary_edges += found.boundary_edges;
  all.non_manifold_edges += found.non_manifold_edges;
  all.has_duplicates = all.has_duplicates || found.has_duplicates;
}

}  // namespace

HalfEdgeMates match_half_edges(std::span<const Triangle> faces, std::size_t vertex_count) {
  assert(faces.size() < kNoHalfEdge / 3);
  HalfEdgeMates mates;
  mates.aligned = FixedArray<std::uint32_t>(3 * faces.size());
  run_ranges(mates.aligned.size(), kMatchingWorthAThread, [&](std::size_t begin, std::size_t end) {
    for (std::size_t h = begin; h < end; ++h) mates.aligned[h] = kNoHalfEdge;
  });
  const std::size_t parts = faces.size() < kMatchingWorthAThread ? 1 : pass_count();
  const std::vector<VertexRange> ranges = balanced_ranges(faces, vertex_count, parts);
  std::vector<EdgeFindings> findings(parts);
  run_each(0, parts,
           [&](std::size_t i) { findings[i] = Matcher(faces, mates.aligned).match(ranges[i]); });
  for (const EdgeFindings& found : findings) add(found, mates);
  std::sort(
      mates.misaligned.begin(), mates.misaligned.end(),
      [](const MisalignedMate& x, const MisalignedMate& y) { return x.half_edge < y.half_edge; });
  return mates;
}

}  // namespace palpate
