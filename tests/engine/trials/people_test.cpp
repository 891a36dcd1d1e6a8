// Trials of the persons of both operator files: a few here, whole blocks with the label soak.

#include <array>
#include <cstdint>
#include <iostream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "engine/trials/operator_file.h"
#include "engine/trials/trial.h"
#include "engine/trials/trial_order.h"
#include "tests/engine/trials/prepared_object.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

constexpr std::uint64_t kSeed = 2005;
constexpr const char* kHaptic[] = {"NoH", "UaH", "H"};
constexpr const char* kRotation[] = {"NoR", "R"};

// Sums over the trials that reached the red sphere, by rotation and haptic level.
struct Sums {
  std::array<std::array<double, 3>, 2> depth_m{}, angle_deg{}, done{};
  int trials = 0;
  int ended_otherwise = 0;

  double mean_depth_m(int rotation, int haptic) const {
    return depth_m[rotation][haptic] / done[rotation][haptic];
  }
  double mean_angle_deg(int rotation) const {
    double sum = 0.0;
    double count = 0.0;
    for (int haptic = 0; haptic < 3; ++haptic) {
      sum += angle_deg[rotation][haptic];
      count += done[rotation][haptic];
    }
    return sum / count;
  }
};

void add_trial(const OperatorParameters& person, Following following, int participant, int block,
               std::size_t object, int rotation, int haptic, Sums& sums) {
  const test::PreparedObject& o = test::prepared_model(test::kPaperObjects[object]);
  const TrialConditions conditions{
      static_cast<ForceMode>(haptic), rotation == 1, following,
      noise_seed(kSeed, participant, block, kHaptic[haptic], kRotation[rotation],
                 "O" + std::to_string(object + 1))};
  const auto outcome = run_trial(o.scene, o.way, o.setup, {}, person, conditions);
  ASSERT_TRUE(outcome.ok());
  ++sums.trials;
  if (outcome->status != TrialStatus::kDone) {
    ++sums.ended_otherwise;
    std::cout << "not done: participant " << participant << ", block " << block << ", "
              << test::kPaperObjects[object] << ", " << kHaptic[haptic] << ", "
              << kRotation[rotation] << "\n";
    return;
  }
  sums.depth_m[rotation][haptic] += outcome->measures[kPenetration].value_or(0.0);
  sums.angle_deg[rotation][haptic] += outcome->measures[kContactAngle].value_or(0.0);
  sums.done[rotation][haptic] += 1.0;
}

struct Case {
  const char* operator_name;
  Following following;
  double least_done;  // share of the trials
};

class PersonsOf : public testing::TestWithParam<Case> {};

TEST_P(PersonsOf, ReachTheRedSphereAndFeelForceAndRotation) {
  const Case& c = GetParam();
  const auto file = load_operator(c.operator_name);
  ASSERT_TRUE(file.ok());
  Sums sums;
  const int participants = test::in_soak_or_else(10, 3);
  const int blocks = test::in_soak_or_else(3, 1);
  for (int participant = 1; participant <= participants; ++participant) {
    const OperatorParameters person = draw_person(*file, kSeed, participant);
    for (int block = 1; block <= blocks; ++block) {
      for (std::size_t object = 0; object < std::size(test::kPaperObjects); ++object) {
        for (int rotation = 0; rotation < 2; ++rotation) {
          for (int haptic = 0; haptic < 3; ++haptic) {
            add_trial(person, c.following, participant, block, object, rotation, haptic, sums);
          }
        }
      }
    }
  }
  std::cout << sums.ended_otherwise << " of " << sums.trials
            << " trials did not reach the red sphere (seed " << kSeed << ")\n";
  EXPECT_LE(sums.ended_otherwise, (1.0 - c.least_done) * sums.trials);
  for (const int rotation : {0, 1}) {
    EXPECT_LT(sums.mean_depth_m(rotation, 2), sums.mean_depth_m(rotation, 1));
    EXPECT_LT(sums.mean_depth_m(rotation, 1), sums.mean_depth_m(rotation, 0));
  }
  EXPECT_LT(sums.mean_angle_deg(1), sums.mean_angle_deg(0) - 10.0);
}

// 99 and 97 % of the 720 trials.
INSTANTIATE_TEST_SUITE_P(
    BothFiles, PersonsOf,
    testing::Values(Case{"people2005", Following::kDelayed, 0.99},
                    Case{"people2005", Following::kPredict, 0.99},
                    Case{"people2005", Following::kReplan, 0.99},
                    Case{"literature", Following::kDelayed, 0.97},
                    Case{"literature", Following::kPredict, 0.97},
                    Case{"literature", Following::kReplan, 0.97}),
    [](const testing::TestParamInfo<Case>& test) {
      return std::string(test.param.operator_name) + "_" +
             std::string(kFollowingNames[static_cast<std::size_t>(test.param.following)]);
    });

}  // namespace
}  // namespace palpate
