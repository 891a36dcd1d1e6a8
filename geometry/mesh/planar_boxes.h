#pragma once

// Points and boxes on an integer grid in a plane, and a tree that finds the boxes that meet a box.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// Requires coordinates below 2^27, so that cross products of differences are exact.
struct GridPoint {
  std::int64_t x, y;

  GridPoint operator-(const GridPoint& o) const { return {x - o.x, y - o.y}; }
  bool operator==(const GridPoint&) const = default;
};

inline std::int64_t cross(const GridPoint& a, const GridPoint& b) {
  return a.x * b.y - a.y * b.x;
}
inline std::int64_t dot(const GridPoint& a, const GridPoint& b) {
  return a.x * b.x + a.y * b.y;
}

struct GridBox {
  GridPoint low, high;

  bool meets(const GridBox& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y;
  }
  GridBox united(const GridBox& o) const {
    return {{std::min(low.x, o.low.x), std::min(low.y, o.low.y)},
            {std::max(high.x, o.high.x), std::max(high.y, o.high.y)}};
  }
  GridBox grown(std::int64_t by) const {
    return {{low.x - by, low.y - by}, {high.x + by, high.y + by}};
  }
};

// An immutable tree over boxes. Thread-safe.
class PlanarBoxes {
 public:
  explicit PlanarBoxes(std::vector<GridBox> boxes);

  // Calls visit(index) for each box that meets `box`, in the order of the tree.
  template <typename Visit>
  void visit(const GridBox& box, const Visit& visit) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const bool is_met = node.box.meets(box);
      if (is_met) {
        for (std::uint32_t k = node.begin; k < node.end; ++k) {
          if (boxes_[order_[k]].meets(box)) visit(order_[k]);
        }
      }
      n = is_met ? n + 1 : node.next;
    }
  }

 private:
  struct Node {
    GridBox box;
    std::uint32_t begin, end;  // boxes of a leaf; empty for inner nodes
    std::size_t next;          // the node after this subtree
  };
  GridBox add_node(std::uint32_t begin, std::uint32_t end);

  std::vector<GridBox> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;  // each node before its descendants
};

}  // namespace palpate
