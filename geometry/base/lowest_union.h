#pragma once

// Disjoint sets of numbers, each represented by its lowest number.

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace palpate {

// R. E. Tarjan, Efficiency of a good but not linear set union algorithm, Journal of the ACM 22(2),
// 1975, with path halving. Because the lowest number represents, a union takes O(log n) amortised.
class LowestUnion {
 public:
  // Sets of one number each: 0 to count - 1.
  explicit LowestUnion(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t lowest(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t i, std::uint32_t j) {
    i = lowest(i);
    j = lowest(j);
    if (i < j) std::swap(i, j);
    parent_[i] = j;
  }
  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;  // never above the number itself
};

}  // namespace palpate
