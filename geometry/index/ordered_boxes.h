#pragma once

// Boxes that are visited in the order of their numbers, from any of them on.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/index/triangle_pack.h"

namespace palpate {

inline constexpr std::uint32_t kBoxLanes = TrianglePack::kLanes;  // of a BoxPack

// How what is near a point is searched for. Embree is fast where few boxes are near, but can't be
// stopped where very many hold the point; in order of their numbers, a search ends at once.
enum class NearSearch : std::uint8_t { kWithEmbree, kInOrder };

// An immutable tree over groups of sixteen boxes (BoxPack): sixteen neighbouring groups have a box
// around each of them in one BoxPack of the level above, and so on up to a level of one. It answers
// what Embree's trees can't: which group comes next, whatever the instruction set, so that a search
// can end anywhere and go on from there later.
//
// Queries: no allocation, lock or exception; thread-safe.
class OrderedBoxes {
 public:
  OrderedBoxes() = default;
  // groups: sixteen boxes each, some of which may be empty (low > high).
  explicit OrderedBoxes(std::span<const BoxPack> groups);

  // The first group, of number `from` or higher, the box around which passes `test`: a function
  // that tells which boxes of a BoxPack do, a bit each. A box around boxes that pass must pass.
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

  // What a tree over so many groups takes.
  static std::uint64_t memory_need(std::uint64_t groups);
  std::size_t memory_bytes() const;

 private:
  std::vector<std::vector<BoxPack>> levels_;  // the lowest first
};

}  // namespace palpate
