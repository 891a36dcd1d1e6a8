#include "engine/analysis/sweep_chance.h"

#include <algorithm>
#include <limits>

#include "engine/trials/key_hash.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

constexpr int kPermutations = 2000;
// Of the difference of two shares: each quotient and the difference is at most 1 and is rounded by
// at most half an epsilon, in the deal that was found and in another one.
constexpr double kDifferenceRounding = 3.0 * std::numeric_limits<double>::epsilon();

double difference_of(const PointSplit& split, const std::vector<bool>& holds) {
  std::vector<int> points(split.parts), held(split.parts);
  for (std::size_t i = 0; i < holds.size(); ++i) {
    if (!split.part_of[i]) continue;
    ++points[*split.part_of[i]];
    held[*split.part_of[i]] += holds[i] ? 1 : 0;
  }
  double smallest = 1.0, largest = 0.0;
  for (std::size_t part = 0; part < split.parts; ++part) {
    if (points[part] == 0) continue;
    const double share = static_cast<double>(held[part]) / points[part];
    smallest = std::min(smallest, share);
    largest = std::max(largest, share);
  }
  return largest - smallest;
}

double largest_difference(const std::vector<PointSplit>& splits, const std::vector<bool>& holds) {
  double largest = 0.0;
  for (const PointSplit& split : splits) largest = std::max(largest, difference_of(split, holds));
  return largest;
}

}  // namespace

double largest_difference_p(const std::vector<PointSplit>& splits, std::vector<bool> holds,
                            std::string_view key) {
  const double found = largest_difference(splits, holds);
  SeededRandom random(KeyHash().add("largest difference").add(key).value());
  int count = 1;
  for (int i = 0; i < kPermutations; ++i) {
    for (std::size_t left = holds.size(); left > 1; --left) {
      const auto other = static_cast<std::size_t>(random.index(left));
      const bool last = holds[left - 1];
      holds[left - 1] = holds[other];
      holds[other] = last;
    }
    if (largest_difference(splits, holds) >= found - kDifferenceRounding) ++count;
  }
  return count / (kPermutations + 1.0);
}

}  // namespace palpate
