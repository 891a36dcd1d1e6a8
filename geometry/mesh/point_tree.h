#pragma once

// A k-d tree of points that finds the points in a box, or near a segment.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/types.h"

namespace palpate {

// J. L. Bentley, Multidimensional binary search trees used for associative searching,
// Communications of the ACM 18(9), 1975. Balanced: every node divides its points at the median
// along the axis of their largest extent. Unlike a PointGrid, it has no cell size: a query is fast
// however dense the points are elsewhere. Any frame. Not for the haptic thread; thread-safe after
// construction.
class PointTree {
 public:
  // The number of a point is its place in `points`. O(n log n).
  explicit PointTree(std::vector<Vec3> points);

  static constexpr std::uint64_t bytes(std::size_t points) {
    return points * (sizeof(Vec3) + sizeof(Entry) + sizeof(Cut)) + 64;
  }

  const Vec3& point(std::uint32_t number) const { return points_[number]; }

  // Calls visit(number) for the points within the box, until visit() returns false. Returns false
  // if it did. The order of the visits is not specified, but depends on the points alone.
  template <typename Visit>
  bool visit_box(const Box& box, const Visit& visit) const {
    return visit_box(root(), box, visit);
  }

  // Calls visit(number) for all points whose distance from the segment from a to b is less than
  // margin_m along each axis, and for some other points, as visit_box() does. Decrements
  // leaves_left for each leaf of the tree that is examined, and returns false if it is 0: a long
  // segment can pass many leaves.
  template <typename Visit>
  bool visit_segment(const Vec3& a, const Vec3& b, const Vec3& margin_m, std::size_t& leaves_left,
                     const Visit& visit) const {
    return visit_segment(root(), {a, b - a, margin_m, leaves_left}, 0.0, 1.0, visit);
  }

 private:
  static constexpr std::uint32_t kLeaf = 8;  // points of a leaf, at most

  // A copy of a point, so that the points of a leaf are side by side in memory.
  struct Entry {
    Vec3 point;
    std::uint32_t number;
  };

  // The points of entries_[begin] to entries_[end - 1]. The children of inner node n are 2n and 2n
  // + 1.
  struct Node {
    std::uint32_t number, begin, end;
    bool is_leaf() const { return end - begin <= kLeaf; }
    std::uint32_t middle() const { return begin + (end - begin) / 2; }
    Node low() const { return {2 * number, begin, middle()}; }
    Node high() const { return {2 * number + 1, middle(), end}; }
  };
  struct Segment {
    Vec3 start, along, margin;
    std::size_t& leaves_left;
  };

  // The plane at which an inner node is divided.
  struct Cut {
    double at = 0.0;
    int axis = 0;
  };

  Node root() const { return {1, 0, static_cast<std::uint32_t>(entries_.size())}; }
  void divide(const Node& node);

  template <typename Visit>
  bool visit_box(const Node& node, const Box& box, const Visit& visit) const {
    if (node.is_leaf()) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (box.contains(entries_[i].point) && !visit(entries_[i].number)) return false;
      }
      return true;
    }
    const Cut& cut = cuts_[node.number];
    if (box.low[cut.axis] <= cut.at && !visit_box(node.low(), box, visit)) return false;
    return !(box.high[cut.axis] >= cut.at) || visit_box(node.high(), box, visit);
  }

  // from, to: the part of the segment that may be near the node's points.
  template <typename Visit>
  bool visit_segment(const Node& node, const Segment& segment, double from, double to,
                     const Visit& visit) const {
    if (node.is_leaf()) {
      if (segment.leaves_left == 0) return false;
      --segment.leaves_left;
      const Vec3 p = segment.start + from * segment.along, q = segment.start + to * segment.along;
      const Box box{p.cwiseMin(q) - segment.margin, p.cwiseMax(q) + segment.margin};
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (box.contains(entries_[i].point) && !visit(entries_[i].number)) return false;
      }
      return true;
    }
    const Cut& cut = cuts_[node.number];
    const double start = segment.start[cut.axis] - cut.at;
    const double along = segment.along[cut.axis];
    const double margin = segment.margin[cut.axis];
    // Where the segment reaches the margin on the far side of the cut.
    const auto clipped = [&](double height, double sign, double& low, double& high) {
      // Keeps the places t with sign * (start + t * along) <= height.
      const double slope = sign * along;
      const double rest = height - sign * start;
      if (slope > 0.0) {
        high = std::min(high, rest / slope);
      } else if (slope < 0.0) {
        low = std::max(low, rest / slope);
      } else if (!(rest >= 0.0)) {
        return false;
      }
      return low <= high;
    };
    double low = from, high = to;
    if (clipped(margin, 1.0, low, high) && !visit_segment(node.low(), segment, low, high, visit)) {
      return false;
    }
    low = from, high = to;
    return !clipped(margin, -1.0, low, high) ||
           visit_segment(node.high(), segment, low, high, visit);
  }

  std::vector<Vec3> points_;
  std::vector<Entry> entries_;  // node by node
  std::vector<Cut> cuts_;       // by the number of the inner node
};

}  // namespace palpate
