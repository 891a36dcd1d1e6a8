#pragma once

// Latin hypercube samples (McKay, Beckman and Conover, 1979).

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace palpate {

// The coordinates of `count` points along one dimension, each in [0, 1). Each of the intervals
// [i / count, (i + 1) / count) has one point, at a uniform place in it; the order of the intervals
// is a random permutation. The numbers depend on these arguments only, so that a further dimension
// changes no other one: the seed of the permutation is the KeyHash of ("hypercube", seed,
// dimension), and that of the place of point i = 0, 1, ... is the KeyHash of ("hypercube", seed,
// dimension, i).
std::vector<double> hypercube_coordinates(std::uint64_t seed, std::string_view dimension,
                                          std::size_t count);

}  // namespace palpate
