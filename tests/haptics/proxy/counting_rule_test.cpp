// Rules of counting: a recording is replayed with the rule that it names, so each rule must keep
// every bit.

#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "benchmarks/worst_inputs.h"
#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/work_budgets.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

using bench::worst_kinds;
using bench::WorstInput;
using bench::WorstKind;

// FNV-1a over the bits of all states of an input with several budgets.
std::uint64_t hash_of(const WorstInput& input, CountingRule rule) {
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
  };
  for (const WorkUnits budget : {300, 4000, 20000}) {
    GodObjectSettings settings{input.proxy_radius_m, test::with_budget({}, budget)};
    settings.accuracy.counting = rule;
    auto god_object = test::made(GodObject::create(input.world, settings));
    god_object.place(input.goals_m.front());
    for (std::size_t i = 0; i < input.goals_m.size(); ++i) {
      const std::uint64_t held =
          input.motions.empty() ? 0 : god_object.move_bodies(input.motions[i]);
      const ProxyState state = god_object.move_to(input.goals_m[i]);
      const std::int64_t numbers[] = {state.work, state.iterations, state.capped,
                                      static_cast<std::int64_t>(held)};
      add(state.proxy.data(), 3 * sizeof(double));
      add(state.normal.data(), 3 * sizeof(double));
      add(numbers, sizeof numbers);
    }
  }
  return hash;
}

// Computed by the program as it was before the second rule.
const std::map<std::string, std::uint64_t> kFirstHashes = {
    {"through_one_point", 0x7cf6d91ec9f9b11bu},
    {"through_one_point_sphere", 0xd0cc58f2945dc7e5u},
    {"through_one_point_large_sphere", 0x618d5c430f4945c1u},
    {"instances_at_one_point", 0xa40d14d78a929aedu},
    {"instances_at_one_point_sphere", 0xd235fffd62daf5bau},
    {"stretched_instances_at_one_point", 0x3bd871b44ddf1248u},
    {"stack_in_one_mesh", 0xf62e5ef4c0c07c99u},
    {"stack_of_bodies", 0xab4a3d9c79ed150bu},
    {"dense_soup", 0x903181ce2e3004fdu},
    {"dense_soup_sphere", 0xed87583838217b73u},
    {"needles_in_doubt", 0xf02c648dd771e8c8u},
    {"needles_in_doubt_sphere", 0x0875ae52aba7af6cu},
    {"sphere_as_large_as_the_scene", 0x1182b618d8edd461u},
    {"moving_bodies", 0x63d6dd6623460c15u},
    {"start_in_a_cluster", 0x86ddc69ffce9f2d5u},
    {"start_in_a_cluster_sphere", 0x3ff03067858c74a3u},
    {"jumps_across", 0x6343d1996d3eb256u},
    {"jumps_across_sphere", 0x82a0637230ca48c0u},
};

// Of the second rule. A hash changes with the way of the solver, too; a change of a price, or of
// what counts, needs a third rule.
const std::map<std::string, std::uint64_t> kSecondHashes = {
    {"through_one_point", 0x98b45ed81555b6c6u},
    {"through_one_point_sphere", 0x17a64460112bc60au},
    {"through_one_point_large_sphere", 0x903d8a8c8fc0e50eu},
    {"instances_at_one_point", 0x3f1ff76bef698343u},
    {"instances_at_one_point_sphere", 0xcde4da85aea7ec24u},
    {"stretched_instances_at_one_point", 0xaa7152ffe1a036b5u},
    {"stack_in_one_mesh", 0x16327474175d05d5u},
    {"stack_of_bodies", 0x4218a205fdcba7efu},
    {"dense_soup", 0x190bdb2853e5c1d2u},
    {"dense_soup_sphere", 0x82ed7e313294c718u},
    {"needles_in_doubt", 0x0b742f1b594307a4u},
    {"needles_in_doubt_sphere", 0xb9e390b6bd98ee14u},
    {"sphere_as_large_as_the_scene", 0x1b124ef0425a59d0u},
    {"moving_bodies", 0x3fbc055f89a4d69bu},
    {"start_in_a_cluster", 0xf5a956d6a8534102u},
    {"start_in_a_cluster_sphere", 0xc72e8d88aa0809d6u},
    {"jumps_across", 0x8500ae8486f1a851u},
    {"jumps_across_sphere", 0x3a7991468dd05f69u},
};

class CountingRules : public testing::TestWithParam<WorstKind> {};

TEST_P(CountingRules, TheFirstOneKeepsEveryBitOfCappedTicks) {
  const auto known = kFirstHashes.find(std::string(GetParam().name));
  ASSERT_NE(known, kFirstHashes.end());
  EXPECT_EQ(hash_of(GetParam().make(GetParam().least), CountingRule::kFirst), known->second);
}

TEST_P(CountingRules, TheSecondOneKeepsEveryBitOfCappedTicks) {
  const auto known = kSecondHashes.find(std::string(GetParam().name));
  ASSERT_NE(known, kSecondHashes.end());
  EXPECT_EQ(hash_of(GetParam().make(GetParam().least), CountingRule::kSecond), known->second);
}

// No input above has effects. Their prices decide the bits of recordings, too.
TEST(CountingRule, TheSecondOneKeepsThePricesOfEffects) {
  EXPECT_EQ(price_of(Work::kNearestPack), 20);
  EXPECT_EQ(price_of(Work::kPlace), 6);
}

INSTANTIATE_TEST_SUITE_P(Of, CountingRules, testing::ValuesIn(worst_kinds()),
                         [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace
}  // namespace palpate
