#include "geometry/index/touching_boxes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace palpate {
namespace {

bool meet(const Box& a, const Box& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  }
  return true;
}

// Bisects space recursively. A box on both sides of a cut belongs to both halves.
class TouchSearch {
 public:
  TouchSearch(std::span<const Box> boxes, const std::vector<bool>& marked)
      : boxes_(boxes), marked_(marked), touches_(boxes.size(), false) {}

  void search(const std::vector<std::uint32_t>& some, int depth) {
    const auto is_marked = [&](std::uint32_t i) { return marked_[i]; };
    if (some.size() < 2 || std::none_of(some.begin(), some.end(), is_marked)) return;
    if (some.size() <= kFew) return compare(some);
    for (const Cut& middle : middles(some)) {
      Halves halves = split(some, middle);
      if (!halves.are_smaller) halves = split(some, {middle.axis, median(some, middle.axis)});
      if (depth == kDeepest || !halves.are_smaller) continue;
      search(halves.low, depth + 1);
      halves.low = {};
      return search(halves.high, depth + 1);
    }
    if (some.size() <= kMostCompared) return compare(some);
    for (const std::uint32_t i : some) touches_[i] = true;
  }

  std::vector<bool> take() { return std::move(touches_); }

 private:
  struct Cut {
    int axis;
    double at;
  };
  struct Halves {
    std::vector<std::uint32_t> low, high;
    bool are_smaller;
  };
  static constexpr std::size_t kFew = 32;  // up to this many boxes are compared one by one
  // The same for boxes that no plane perpendicular to an axis divides well. More boxes are a crowd.
  static constexpr std::size_t kMostCompared = 512;
  // Each half of a cut must exclude at least 1 / kOneLeftOutOf of the boxes.
  static constexpr std::size_t kOneLeftOutOf = 4;
  static constexpr int kDeepest = 64;

  void compare(std::span<const std::uint32_t> some) {
    for (std::size_t n = 0; n < some.size(); ++n) {
      for (std::size_t m = n + 1; m < some.size(); ++m) {
        const std::uint32_t i = some[n];
        const std::uint32_t j = some[m];
        if (!meet(boxes_[i], boxes_[j])) continue;
        if (marked_[i] || marked_[j]) touches_[i] = touches_[j] = true;
      }
    }
  }

  // The midpoints of the boxes' low ends, one cut per axis, in descending order of spread.
  std::array<Cut, 3> middles(std::span<const std::uint32_t> some) const {
    Vec3 low = boxes_[some[0]].low;
    Vec3 high = low;
    for (const std::uint32_t i : some) {
      low = low.cwiseMin(boxes_[i].low);
      high = high.cwiseMax(boxes_[i].low);
    }
    std::array<int, 3> axes = {0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(),
                     [&](int a, int b) { return high[a] - low[a] > high[b] - low[b]; });
    std::array<Cut, 3> cuts;
    for (std::size_t n = 0; n < 3; ++n) {
      cuts[n] = {axes[n], 0.5 * low[axes[n]] + 0.5 * high[axes[n]]};
    }
    return cuts;
  }

  double median(std::span<const std::uint32_t> some, int axis) const {
    std::vector<double> begins;
    begins.reserve(some.size());
    for (const std::uint32_t i : some) begins.push_back(boxes_[i].low[axis]);
    const auto middle = begins.begin() + static_cast<std::ptrdiff_t>(begins.size() / 2);
    std::nth_element(begins.begin(), middle, begins.end());
    return *middle;
  }

  // A box belongs to the low half if it has points below the cut, and to the high half if it has
  // points at or above the cut. Two boxes that meet have a common point in one of the halves.
  Halves split(std::span<const std::uint32_t> some, const Cut& cut) const {
    Halves halves;
    halves.low.reserve(some.size());
    halves.high.reserve(some.size());
    for (const std::uint32_t i : some) {
      if (boxes_[i].low[cut.axis] < cut.at) halves.low.push_back(i);
      if (boxes_[i].high[cut.axis] >= cut.at) halves.high.push_back(i);
    }
    halves.are_smaller = std::max(halves.low.size(), halves.high.size()) <=
                         some.size() - some.size() / kOneLeftOutOf;
    return halves;
  }

  std::span<const Box> boxes_;
  const std::vector<bool>& marked_;
  std::vector<bool> touches_;
};

}  // namespace

std::vector<bool> may_touch_marked(std::span<const Box> boxes, const std::vector<bool>& marked) {
  TouchSearch search(boxes, marked);
  std::vector<std::uint32_t> all(boxes.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  search.search(all, 0);
  return search.take();
}

}  // namespace palpate
