#pragma once

// The order of the conditions, and the seeds of all random numbers of an experiment. No seed
// depends on what ran before.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

// Every seed is the KeyHash of the listed fields, with the purpose first. seed: the seed of the
// plan. participant: 1 for the first. block: 0 for practice.

// ("order", seed, participant, block)
std::uint64_t order_seed(std::uint64_t seed, int participant, int block);
// ("objects", seed, participant, block, level): the order of the objects of one condition in a
// Williams square. level: ExperimentPlan::level_name().
std::uint64_t objects_seed(std::uint64_t seed, int participant, int block,
                           const std::string& level);
// ("noise", seed, participant, block, haptic, rotation, object): the same for all Followings. In a
// plan with strategies, haptic and rotation are empty, so that it is the same for all strategies.
std::uint64_t noise_seed(std::uint64_t seed, int participant, int block, const std::string& haptic,
                         const std::string& rotation, const std::string& object);
// ("draw", seed, participant, operator name, draw name)
std::uint64_t draw_seed(std::uint64_t seed, int participant, const std::string& operator_name,
                        const std::string& draw);

// A random permutation of 0 to count - 1 (Fisher and Yates), uniform over all permutations.
std::vector<std::size_t> trial_order(std::size_t count, std::uint64_t seed);

// A row of a Williams square (Williams, Aust J Sci Res A 2, 1949): an order of 0 to count - 1, with
// count even. Row 0 is 0, 1, count - 1, 2, count - 2, ...; row r is row 0 plus r, modulo count. In
// the rows 0 to count - 1, each number has each place once, and each ordered pair of numbers
// succeeds once.
std::vector<std::size_t> williams_row(std::size_t count, std::size_t row);

}  // namespace palpate
