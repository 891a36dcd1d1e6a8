#pragma once

// How often chance alone makes the largest of many differences as large as the one that was found.

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace palpate {

// A division of points into parts, for example the halves of a parameter. part_of: of each point,
// below `parts`; no value: the point is in no part.
struct PointSplit {
  std::vector<std::optional<std::size_t>> part_of;
  std::size_t parts = 0;
};

// A permutation test. A split's difference is the largest minus the smallest share, over its parts,
// of the points that hold; the statistic is the largest difference of all splits. Each of 2,000
// permutations deals `holds` to the points anew, for all splits at once. p is the share of these
// deals, with the one that was found counted among them, whose statistic is at least the one found:
// (1 + count) / 2,001. key: the random numbers follow from it.
double largest_difference_p(const std::vector<PointSplit>& splits, std::vector<bool> holds,
                            std::string_view key);

}  // namespace palpate
