#include "geometry/mesh/point_tree.h"

#include <numeric>
#include <tuple>

namespace palpate {

PointTree::PointTree(std::vector<Vec3> points)
    : points_(std::move(points)), order_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  // A balanced tree whose leaves have more than half of kLeaf points.
  std::size_t nodes = 2;
  while (nodes * (kLeaf / 2) < 2 * points_.size()) nodes *= 2;
  cuts_.resize(nodes);
  divide(root());
}

void PointTree::divide(const Node& node) {
  if (node.is_leaf()) return;
  Box box{points_[order_[node.begin]], points_[order_[node.begin]]};
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    box = box.united({points_[order_[i]], points_[order_[i]]});
  }
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  const auto at = [&](std::uint32_t i) { return order_.begin() + i; };
  std::nth_element(at(node.begin), at(node.middle()), at(node.end),
                   [&](std::uint32_t i, std::uint32_t j) {
                     return std::pair(points_[i][axis], i) < std::pair(points_[j][axis], j);
                   });
  cuts_[node.number] = {points_[order_[node.middle()]][axis], axis};
  divide(node.low());
  divide(node.high());
}

}  // namespace palpate
