#include "geometry/index/overlap_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace palpate {

OverlapTree::OverlapTree(const std::vector<Box>& boxes) : order_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(2 * boxes.size() / kInLeaf + 2);
  build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
  boxes_.reserve(boxes.size());
  for (const std::uint32_t i : order_) boxes_.push_back(boxes[i]);
}

// Halves the boxes at the median of their middles, along the axis where these spread most.
void OverlapTree::build(const std::vector<Box>& boxes, std::uint32_t begin, std::uint32_t end) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({Box::empty(), begin, end});
  Box middles = Box::empty();
  for (std::uint32_t i = begin; i < end; ++i) {
    const Box& box = boxes[order_[i]];
    nodes_[number].box = nodes_[number].box.united(box);
    const Vec3 sum = 0.5 * box.low + 0.5 * box.high;
    middles = middles.united({sum, sum});
  }
  if (end - begin <= kInLeaf) return;
  int axis = 0;
  (middles.high - middles.low).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto key = [&](std::uint32_t i) {
    return std::pair(0.5 * boxes[i].low[axis] + 0.5 * boxes[i].high[axis], i);
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
  build(boxes, begin, middle);
  nodes_[number].right = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, middle, end);
}

}  // namespace palpate
