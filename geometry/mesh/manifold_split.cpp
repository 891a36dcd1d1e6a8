#include "geometry/mesh/manifold_split.h"

#include <utility>

namespace palpate {
namespace {

// The corner at the same vertex in the next face, counter-clockwise or clockwise as seen from the
// front, or kNoHalfEdge. If a half-edge ends at a vertex, its aligned mate starts there.
std::uint32_t counter_clockwise(const HalfEdgeMates& mates, std::uint32_t corner) {
  return mates.aligned[previous_half_edge(corner)];
}

std::uint32_t clockwise(const HalfEdgeMates& mates, std::uint32_t corner) {
  const std::uint32_t mate = mates.aligned[corner];
  return mate == kNoHalfEdge ? kNoHalfEdge : next_half_edge(mate);
}

class Splitter {
 public:
  Splitter(std::span<const Triangle> faces, const HalfEdgeMates& mates, std::size_t vertex_count)
      : faces_(faces),
        mates_(mates),
        vertex_count_(vertex_count),
        is_done_(3 * faces.size(), false),
        has_fan_(vertex_count, false) {}

  ManifoldSplit run() {
    for (std::uint32_t corner = 0; corner < is_done_.size(); ++corner) {
      if (is_done_[corner]) continue;
      const std::uint32_t original = faces_[corner / 3][corner % 3];
      if (!has_fan_[original]) {
        has_fan_[original] = true;
        visit_fan(corner, [](std::uint32_t) {});
        continue;
      }
      const auto vertex = static_cast<std::uint32_t>(vertex_count_ + split_.copied_vertices.size());
      split_.copied_vertices.push_back(original);
      visit_fan(corner, [&](std::uint32_t c) { split_.corners.push_back({c, vertex}); });
    }
    return std::move(split_);
  }

 private:
  // Visits every corner in the fan of `start`.
  template <typename Visit>
  void visit_fan(std::uint32_t start, const Visit& visit) {
    const auto take = [&](std::uint32_t corner) {
      is_done_[corner] = true;
      visit(corner);
    };
    std::uint32_t corner = start;
    do {
      take(corner);
      corner = counter_clockwise(mates_, corner);
    } while (corner != kNoHalfEdge && corner != start);
    if (corner == start) return;
    corner = clockwise(mates_, start);
    for (; corner != kNoHalfEdge; corner = clockwise(mates_, corner)) take(corner);
  }

  std::span<const Triangle> faces_;
  const HalfEdgeMates& mates_;
  std::size_t vertex_count_;
  std::vector<bool> is_done_;  // per corner
  std::vector<bool> has_fan_;  // per original vertex
  ManifoldSplit split_;
};

}  // namespace

std::vector<Triangle> ManifoldSplit::split_faces(std::span<const Triangle> faces) const {
  std::vector<Triangle> split;
  if (corners.empty()) return split;
  split.assign(faces.begin(), faces.end());
  for (const Corner& c : corners) split[c.corner / 3][c.corner % 3] = c.vertex;
  return split;
}

ManifoldSplit split_to_manifold(std::span<const Triangle> faces, const HalfEdgeMates& mates,
                                std::size_t vertex_count) {
  return Splitter(faces, mates, vertex_count).run();
}

}  // namespace palpate
