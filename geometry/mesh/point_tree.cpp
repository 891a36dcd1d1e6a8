#include "geometry/mesh/point_tree.h"

#include <utility>

namespace palpate {

PointTree::PointTree(std::vector<Vec3> points) : points_(std::move(points)) {
  entries_.reserve(points_.size());
  for (std::uint32_t i = 0; i < points_.size(); ++i) entries_.push_back({points_[i], i});
  // A balanced tree whose leaves have more than half of kLeaf points.
  std::size_t nodes = 2;
  while (nodes * (kLeaf / 2) < 2 * points_.size()) nodes *= 2;
  cuts_.resize(nodes);
  divide(root());
}

void PointTree::divide(const Node& node) {
  if (node.is_leaf()) return;
  Box box = Box::empty();
  for (std::uint32_t i = node.begin; i < node.end; ++i) {
    box = box.united({entries_[i].point, entries_[i].point});
  }
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  const auto at = [&](std::uint32_t i) { return entries_.begin() + i; };
  std::nth_element(at(node.begin), at(node.middle()), at(node.end),
                   [axis](const Entry& a, const Entry& b) {
                     return std::pair(a.point[axis], a.number) < std::pair(b.point[axis], b.number);
                   });
  cuts_[node.number] = {entries_[node.middle()].point[axis], axis};
  divide(node.low());
  divide(node.high());
}

}  // namespace palpate
