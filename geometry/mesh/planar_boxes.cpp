#include "geometry/mesh/planar_boxes.h"

#include <numeric>
#include <utility>

namespace palpate {
namespace {

constexpr std::uint32_t kFew = 8;  // up to this many boxes form a leaf

}  // namespace

PlanarBoxes::PlanarBoxes(std::vector<GridBox> boxes)
    : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!order_.empty()) add_node(0, static_cast<std::uint32_t>(order_.size()));
}

// Splits at the median of the boxes' middles, along the axis with the larger spread of middles.
GridBox PlanarBoxes::add_node(std::uint32_t begin, std::uint32_t end) {
  const auto middle = [&](std::uint32_t i) {
    return GridPoint{boxes_[i].low.x + boxes_[i].high.x, boxes_[i].low.y + boxes_[i].high.y};
  };
  GridBox box = boxes_[order_[begin]];
  GridBox middles{middle(order_[begin]), middle(order_[begin])};
  for (std::uint32_t k = begin; k < end; ++k) {
    box = box.united(boxes_[order_[k]]);
    middles = middles.united({middle(order_[k]), middle(order_[k])});
  }
  const std::size_t n = nodes_.size();
  nodes_.push_back({box, begin, end, 0});
  if (end - begin > kFew) {
    nodes_[n].end = begin;
    const GridPoint spread = middles.high - middles.low;
    const bool along_x = spread.x >= spread.y;
    const auto at = [&](std::uint32_t i) { return along_x ? middle(i).x : middle(i).y; };
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + half, order_.begin() + end,
        [&](std::uint32_t i, std::uint32_t k) { return at(i) != at(k) ? at(i) < at(k) : i < k; });
    add_node(begin, half);
    add_node(half, end);
  }
  nodes_[n].next = nodes_.size();
  return box;
}

}  // namespace palpate
