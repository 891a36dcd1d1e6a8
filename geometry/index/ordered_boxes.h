#pragma once

// A tree that visits boxes in ascending order of their numbers, starting at any number.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/index/triangle_pack.h"

namespace palpate {

inline constexpr std::uint32_t kBoxLanes = TrianglePack::kLanes;  // number of boxes in a BoxPack

// The method of a search near a point. Embree is fast if few boxes are near, but its search cannot
// be stopped before it has visited all boxes that contain the point. A search in order of numbers
// can stop at any box.
enum class NearSearch : std::uint8_t { kWithEmbree, kInOrder };

// The work of a query, as numbers that do not depend on the instruction set.
struct QueryWork {
  std::size_t listed = 0;  // found together with too many others, so that the search was repeated
  std::size_t sorted = 0;  // found and sorted
  std::size_t boxes = 0;   // tests of sixteen boxes in a search in order of numbers
};

// Counts the tests of sixteen boxes.
template <typename Test>
struct CountedTest {
  const Test& test;
  std::size_t& count;
  std::uint32_t operator()(const BoxPack& boxes) const {
    ++count;
    return test(boxes);
  }
};

// An immutable tree over groups of sixteen boxes (BoxPack). One BoxPack of the next level holds the
// bounding boxes of sixteen consecutive groups, and so on, up to a level of one BoxPack. Unlike
// Embree's trees, the tree finds the next group in a fixed order that does not depend on the
// instruction set. A search can therefore stop at any group and resume there later.
//
// Queries: no allocation, lock or exception; thread-safe.
class OrderedBoxes {
 public:
  OrderedBoxes() = default;
  // groups: sixteen boxes each; a box may be empty (low > high).
  explicit OrderedBoxes(std::span<const BoxPack> groups);

  // Returns the first group with number >= `from` whose bounding box passes `test`. `test` takes a
  // BoxPack and returns one bit per box. If a box passes, every box that contains it must pass.
  template <typename Test>
  std::optional<std::uint32_t> next(std::uint32_t from, Test test) const noexcept {
    std::size_t level = 0;
    std::uint32_t number = from;
    while (level < levels_.size()) {
      const std::uint32_t pack = number / TrianglePack::kLanes;
      if (pack >= levels_[level].size()) return std::nullopt;
      const std::uint32_t passed = test(levels_[level][pack]) >> (number % TrianglePack::kLanes);
      if (passed == 0) {
        number = pack + 1;
        ++level;
        continue;
      }
      number += static_cast<std::uint32_t>(__builtin_ctz(passed));
      if (level == 0) return number;
      --level;
      number *= TrianglePack::kLanes;
    }
    return std::nullopt;
  }

  // The number of levels, and one BoxPack of a level; level 0 holds the boxes of the groups.
  std::size_t level_count() const { return levels_.size(); }
  const BoxPack& boxes(std::size_t level, std::uint32_t pack) const { return levels_[level][pack]; }

  // The bytes needed for a tree over this number of groups.
  static std::uint64_t memory_need(std::uint64_t groups);
  std::size_t memory_bytes() const;

 private:
  std::vector<std::vector<BoxPack>> levels_;  // the lowest first
};

}  // namespace palpate
