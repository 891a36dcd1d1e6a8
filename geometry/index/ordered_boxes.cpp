#include "geometry/index/ordered_boxes.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

// The bounding boxes of groups, sixteen per pack.
std::vector<BoxPack> boxes_around(std::span<const BoxPack> groups) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<BoxPack> around((groups.size() + kBoxLanes - 1) / kBoxLanes);
  for (BoxPack& pack : around) {
    for (int k = 0; k < 3; ++k) {
      std::fill(std::begin(pack.low[k]), std::end(pack.low[k]), kInfinity);
      std::fill(std::begin(pack.high[k]), std::end(pack.high[k]), -kInfinity);
    }
  }
  for (std::size_t group = 0; group < groups.size(); ++group) {
    BoxPack& pack = around[group / kBoxLanes];
    for (int k = 0; k < 3; ++k) {
      const auto& low = groups[group].low[k];
      const auto& high = groups[group].high[k];
      pack.low[k][group % kBoxLanes] = *std::min_element(std::begin(low), std::end(low));
      pack.high[k][group % kBoxLanes] = *std::max_element(std::begin(high), std::end(high));
    }
  }
  return around;
}

}  // namespace

OrderedBoxes::OrderedBoxes(std::span<const BoxPack> groups) {
  while (!groups.empty()) {
    levels_.push_back(boxes_around(groups));
    if (levels_.back().size() == 1) break;
    groups = levels_.back();
  }
}

std::uint64_t OrderedBoxes::memory_need(std::uint64_t groups) {
  std::uint64_t boxes = 0;
  while (groups > 0) {
    groups = (groups + kBoxLanes - 1) / kBoxLanes;
    boxes += groups;
    if (groups == 1) break;
  }
  return boxes * sizeof(BoxPack);
}

std::size_t OrderedBoxes::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& level : levels_) bytes += level.size() * sizeof(BoxPack);
  return bytes;
}

}  // namespace palpate
