#include "geometry/manifold_split.h"

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

class Splitter {
 public:
  Splitter(std::vector<Triangle>& faces, const HalfEdgeMates& mates, std::size_t vertex_count)
      : faces_(faces),
        mates_(mates),
        vertex_count_(vertex_count),
        is_done_(3 * faces.size(), false),
        has_fan_(vertex_count, false) {}

  std::vector<std::uint32_t> run() {
    std::vector<std::uint32_t> copied_vertices;
    for (std::uint32_t corner = 0; corner < is_done_.size(); ++corner) {
      if (is_done_[corner]) continue;
      const std::uint32_t original = faces_[corner / 3][corner % 3];
      std::uint32_t vertex = original;
      if (has_fan_[original]) {
        vertex = static_cast<std::uint32_t>(vertex_count_ + copied_vertices.size());
        copied_vertices.push_back(original);
      }
      has_fan_[original] = true;
      assign_fan(corner, vertex);
    }
    return copied_vertices;
  }

 private:
  // Makes `vertex` the vertex of every corner in the fan of `start`.
  void assign_fan(std::uint32_t start, std::uint32_t vertex) {
    std::uint32_t corner = start;
    do {
      assign(corner, vertex);
      corner = counter_clockwise(mates_, corner);
    } while (corner != kNoHalfEdge && corner != start);
    if (corner == start) return;
    corner = clockwise(mates_, start);
    for (; corner != kNoHalfEdge; corner = clockwise(mates_, corner)) assign(corner, vertex);
  }

  void assign(std::uint32_t corner, std::uint32_t vertex) {
    is_done_[corner] = true;
    faces_[corner / 3][corner % 3] = vertex;
  }

  std::vector<Triangle>& faces_;
  const HalfEdgeMates& mates_;
  std::size_t vertex_count_;
  std::vector<bool> is_done_;  // per corner
  std::vector<bool> has_fan_;  // per original vertex
};

}  // namespace

std::vector<std::uint32_t> split_to_manifold(std::vector<Triangle>& faces,
                                             const HalfEdgeMates& mates, std::size_t vertex_count) {
  return Splitter(faces, mates, vertex_count).run();
}

}  // namespace palpate
