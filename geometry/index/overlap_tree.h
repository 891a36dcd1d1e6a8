#pragma once

// A tree over boxes in double, for load time.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/box.h"

namespace palpate {

// Finds the boxes that meet a given box. Any frame. Immutable after construction; deterministic.
// Allocates only when constructed; not meant for the haptic thread, whose trees are BoxTree and
// SurfaceIndex.
class OverlapTree {
 public:
  explicit OverlapTree(const std::vector<Box>& boxes);  // O(n log n)

  // The memory that a tree over this number of boxes needs, including its construction.
  static std::uint64_t bytes(std::uint64_t boxes) {
    return boxes * (sizeof(Box) + 2 * sizeof(std::uint32_t)) +
           (2 * boxes / kInLeaf + 2) * sizeof(Node);
  }

  // Calls visit(i) for each box i that meets `box`, until visit returns false. Adds the number of
  // examined nodes and boxes to `work`.
  template <typename Visit>
  void visit(const Box& box, std::uint64_t& work, Visit visit) const {
    if (nodes_.empty()) return;
    std::array<std::uint32_t, kDeepest> open;
    std::size_t count = 0;
    open[count++] = 0;
    while (count > 0) {
      const std::uint32_t n = open[--count];
      ++work;
      const Node& node = nodes_[n];
      if (!meet(node.box, box)) continue;
      if (node.right != 0) {
        open[count++] = node.right;
        open[count++] = n + 1;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        ++work;
        if (meet(boxes_[i], box) && !visit(order_[i])) return;
      }
    }
  }

  static bool meet(const Box& a, const Box& b) {
    return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
  }

 private:
  static constexpr std::uint32_t kInLeaf = 4;
  // Both halves of a node have the same number of boxes, up to one.
  static constexpr std::size_t kDeepest = 64;

  struct Node {
    Box box;
    std::uint32_t begin, end;  // of order_
    std::uint32_t right = 0;   // the second child, after the first one; 0: a leaf
  };

  void build(const std::vector<Box>& boxes, std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<Box> boxes_;  // in the order of order_
};

}  // namespace palpate
