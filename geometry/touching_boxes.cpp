#include "geometry/touching_boxes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace palpate {
namespace {

bool meet(const Box& a, const Box& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

// Cuts space in two where half of the boxes begin, again and again; boxes on both sides of a cut go
// along with either side.
class TouchSearch {
 public:
  TouchSearch(std::span<const Box> boxes, const std::vector<bool>& marked)
      : boxes_(boxes), marked_(marked), touches_(boxes.size(), false) {}

  void search(const std::vector<std::uint32_t>& some, int depth) {
    const auto is_marked = [&](std::uint32_t i) { return marked_[i]; };
    if (some.size() < 2 || std::none_of(some.begin(), some.end(), is_marked)) return;
    if (some.size() <= kFew) return compare(some);
    for (const int axis : axes_by_width(some)) {
      Halves halves = cut(some, axis);
      const std::size_t most = some.size() - some.size() / kOneLeftOutOf;
      if (depth == kDeepest || std::max(halves.low.size(), halves.high.size()) > most) continue;
      search(halves.low, depth + 1);
      halves.low = {};
      return search(halves.high, depth + 1);
    }
    if (some.size() <= kMostCompared) return compare(some);
    for (const std::uint32_t i : some) touches_[i] = true;
  }

  std::vector<bool> take() { return std::move(touches_); }

 private:
  struct Halves {
    std::vector<std::uint32_t> low, high;
  };
  static constexpr std::size_t kFew = 16;  // are compared one by one
  // So are more that no plane across an axis cuts well, up to so many; beyond, they are a crowd.
  static constexpr std::size_t kMostCompared = 512;
  // A cut must leave out one of so many on either side.
  static constexpr std::size_t kOneLeftOutOf = 4;
  static constexpr int kDeepest = 64;

  void compare(std::span<const std::uint32_t> some) {
    for (std::size_t n = 0; n < some.size(); ++n) {
      for (std::size_t m = n + 1; m < some.size(); ++m) {
        const std::uint32_t i = some[n];
        const std::uint32_t j = some[m];
        if ((!marked_[i] && !marked_[j]) || !meet(boxes_[i], boxes_[j])) continue;
        touches_[i] = touches_[j] = true;
      }
    }
  }

  // The axis along which their beginnings are spread most comes first.
  std::array<int, 3> axes_by_width(std::span<const std::uint32_t> some) const {
    Vec3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = high[axis] = boxes_[some[0]].low[axis];
      for (const std::uint32_t i : some) {
        low[axis] = std::min(low[axis], boxes_[i].low[axis]);
        high[axis] = std::max(high[axis], boxes_[i].low[axis]);
      }
    }
    std::array<int, 3> axes = {0, 1, 2};
    std::sort(axes.begin(), axes.end(), [&](int a, int b) {
      const double width_a = high[a] - low[a];
      const double width_b = high[b] - low[b];
      return width_a != width_b ? width_a > width_b : a < b;
    });
    return axes;
  }

  // Below the cut is what has less than it, above what has as much or more: two boxes that meet
  // have a point in common that is either.
  Halves cut(std::span<const std::uint32_t> some, int axis) {
    std::vector<double> begins;
    begins.reserve(some.size());
    for (const std::uint32_t i : some) begins.push_back(boxes_[i].low[axis]);
    const auto median = begins.begin() + static_cast<std::ptrdiff_t>(begins.size() / 2);
    std::nth_element(begins.begin(), median, begins.end());
    Halves halves;
    halves.low.reserve(some.size());
    halves.high.reserve(some.size());
    for (const std::uint32_t i : some) {
      if (boxes_[i].low[axis] < *median) halves.low.push_back(i);
      if (boxes_[i].high[axis] >= *median) halves.high.push_back(i);
    }
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
