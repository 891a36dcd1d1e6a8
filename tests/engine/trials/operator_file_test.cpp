#include "engine/trials/operator_file.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "engine/trials/key_hash.h"
#include "engine/trials/trial_order.h"

namespace palpate {
namespace {

// The values were computed with a second implementation, in Python, of the definition in
// key_hash.h.
TEST(KeyHash, HasTheValuesOfItsDefinition) {
  EXPECT_EQ(KeyHash().value(), 0xefd01f60ba992926u);
  EXPECT_EQ(KeyHash().add("").value(), 0x6898fe3d08c5a427u);
  EXPECT_EQ(KeyHash().add(std::uint64_t{0}).value(), 0x9e8f3e8eabb64105u);
  EXPECT_EQ(KeyHash().add("ab").add("c").value(), 0x2c2b3dd6a23d5adeu);
  EXPECT_EQ(KeyHash().add("a").add("bc").value(), 0xba25b63973318bdau);
  EXPECT_EQ(order_seed(2005, 1, 1), 0xef373f2a9f169fd2u);
  EXPECT_EQ(noise_seed(2005, 10, 3, "UaH", "R", "O4"), 0x8278cdf4946df07du);
  EXPECT_EQ(hash_text(0xabc), "0000000000000abc");
}

TEST(KeyHash, GivesEveryTrialOfALargePlanItsOwnSeed) {
  std::set<std::uint64_t> seeds;
  std::size_t count = 0;
  for (const std::uint64_t seed : {1u, 2u}) {
    for (int participant = 1; participant <= 100; ++participant) {
      for (int block = 0; block <= 3; ++block) {
        for (const char* haptic : {"NoH", "UaH", "H"}) {
          for (const char* rotation : {"NoR", "R"}) {
            for (const char* object : {"O1", "O2", "O3", "O4"}) {
              seeds.insert(noise_seed(seed, participant, block, haptic, rotation, object));
              ++count;
            }
          }
        }
      }
    }
  }
  EXPECT_EQ(seeds.size(), count);
}

TEST(TrialOrder, IsAPermutationAndUniform) {
  // Each of the 24 permutations of 4 conditions is expected 1000 times, with a standard deviation
  // of 31; chi squared has 23 degrees of freedom, and exceeds 49.7 with probability 0.1 %.
  std::map<std::vector<std::size_t>, int> counts;
  constexpr int kBlocks = 24000;
  for (int i = 0; i < kBlocks; ++i) ++counts[trial_order(4, order_seed(7, 1 + i / 4, i % 4))];
  ASSERT_EQ(counts.size(), 24u);
  double chi_squared = 0.0;
  for (const auto& [order, count] : counts) {
    EXPECT_EQ(std::set<std::size_t>(order.begin(), order.end()).size(), 4u);
    chi_squared += (count - 1000.0) * (count - 1000.0) / 1000.0;
  }
  EXPECT_LT(chi_squared, 49.7);
}

// A change of a file is a new version: add 1 to its "version" and change the hash here.
TEST(OperatorFile, ShippedFilesHaveTheseHashes) {
  EXPECT_EQ(hash_text(load_operator("literature")->hash), "56878fd469c5a106");
  EXPECT_EQ(hash_text(load_operator("people2005")->hash), "dfa8fe0211673c67");
}

TEST(OperatorFile, ShippedFilesSayThatASketchWasSeen) {
  for (const std::string_view name : kShippedOperators) {
    const auto file = load_operator(std::string(name));
    ASSERT_TRUE(file.ok()) << file.error().to_string();
    EXPECT_EQ(file->name, name);
    EXPECT_NE(file->note.find("A sketch of this operator was seen before this file was written"),
              std::string::npos);
  }
}

TEST(OperatorFile, PersonsLieInTheRanges) {
  for (const std::string_view name : kShippedOperators) {
    const OperatorFile file = *load_operator(std::string(name));
    for (int participant = 1; participant <= 200; ++participant) {
      const OperatorParameters person = draw_person(file, 2005, participant);
      for (std::size_t i = 0; i < kPersonParameterCount; ++i) {
        const double value = person.*person_parameters()[i].field;
        EXPECT_GE(value, file.ranges[i].low) << person_parameters()[i].name;
        EXPECT_LE(value, file.ranges[i].high) << person_parameters()[i].name;
      }
    }
  }
}

// D = 9.3 - 0.8 x mm and s = 6.0 + 1.2 x mm with the same x.
TEST(OperatorFile, People2005SharesOneNumberBetweenDepthAndNoise) {
  const OperatorFile file = *load_operator("people2005");
  double least = 1.0;
  double most = 0.0;
  for (int participant = 1; participant <= 100; ++participant) {
    const OperatorParameters person = draw_person(file, 2005, participant);
    const double x = (person.intention_noise_m - 4.3e-3) / 4.1e-3;
    EXPECT_NEAR(person.press_depth_m, 5.1e-3 + 8.0e-3 * x, 1e-15);
    least = std::min(least, x);
    most = std::max(most, x);
  }
  EXPECT_LT(least, 0.1);
  EXPECT_GT(most, 0.9);
}

TEST(OperatorFile, AParameterThatFallsIsTheOtherEndOfItsRange) {
  const OperatorFile file = *load_operator("people2005");
  OperatorFile falling = file;
  const auto& parameters = person_parameters();
  const auto depth = std::find_if(parameters.begin(), parameters.end(),
                                  [](const auto& each) { return each.name == "press_depth_m"; });
  const auto place = static_cast<std::size_t>(depth - parameters.begin());
  falling.ranges[place].falls = true;
  for (int participant = 1; participant <= 20; ++participant) {
    const OperatorParameters person = draw_person(file, 2005, participant);
    const OperatorParameters other = draw_person(falling, 2005, participant);
    EXPECT_NEAR(person.press_depth_m + other.press_depth_m,
                file.ranges[place].low + file.ranges[place].high, 1e-15);
    EXPECT_EQ(person.intention_noise_m, other.intention_noise_m);
  }
}

TEST(OperatorFile, PersonsDependOnSeedParticipantAndOperatorOnly) {
  const OperatorFile file = *load_operator("literature");
  const double depth_m = draw_person(file, 2005, 3).press_depth_m;
  EXPECT_EQ(draw_person(file, 2005, 3).press_depth_m, depth_m);
  EXPECT_NE(draw_person(file, 2006, 3).press_depth_m, depth_m);
  EXPECT_NE(draw_person(file, 2005, 4).press_depth_m, depth_m);
  OperatorFile renamed = file;
  renamed.name = "other";
  EXPECT_NE(draw_person(renamed, 2005, 3).press_depth_m, depth_m);
  OperatorFile edited = file;
  edited.ranges[0].high *= 2;  // the range of another parameter
  EXPECT_EQ(draw_person(edited, 2005, 3).press_depth_m, depth_m);
}

}  // namespace
}  // namespace palpate
