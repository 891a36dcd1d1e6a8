// The simulated person at the canonical wall, and the measures of a trial with such a person.

#include "engine/trials/canonical/canonical_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/rig/rig.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/simulated_run.h"
#include "engine/trials/canonical/canonical_measures.h"
#include "engine/trials/canonical/canonical_wall.h"
#include "engine/trials/operator_file.h"
#include "engine/trials/trial.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kTick_s = 1e-3;

RunSetup device_setup(double radius_m = 0.0) {
  RunSettings settings;
  settings.sensors = 2;
  settings.actuators = 1;
  settings.haptics.coupling.damping_Ns_per_m = 2.0;
  settings.haptics.god_object.radius_m = radius_m;
  const auto setup = make_setup(settings);
  EXPECT_TRUE(setup.ok());
  return *setup;
}

// The pose at a time of a wall that turns and moves all the time.
ScenePose moving_pose(double time_s) {
  return {Quat(Eigen::AngleAxisd(0.7 * time_s, Vec3::UnitZ())), Vec3(0.01 * time_s, 0.02, 0.0)};
}

// The target in the scene, by the statement of canonical_hand.h; s since the person began.
Vec3 stated_aim(const OperatorParameters& person, CanonicalMotion motion, double radius_m,
                double s) {
  const double depth_m =
      s < 1.0 ? -2.0 * person.press_depth_m + 3.0 * person.press_depth_m * s : person.press_depth_m;
  double along_m = 0.0;
  if (motion == CanonicalMotion::kStroked && s > 3.0) {
    along_m = std::min(0.1, person.speed_m_per_s * (s - 3.0));
  }
  return {radius_m - depth_m, along_m, 0.0};
}

TEST(CanonicalHand, AimsAtTheWallOfTheNewestPictureOldEnough) {
  test::Random random(3100);
  for (int run = 0; run < 20; ++run) {
    OperatorParameters person;
    person.sight_delay_s = random.uniform(0.01, 0.3);
    person.press_depth_m = random.uniform(2e-3, 12e-3);
    person.speed_m_per_s = random.uniform(0.02, 0.2);
    const double display_Hz = random.uniform(20.0, 200.0);
    const double radius_m = random.uniform(0.0, 5e-3);
    const CanonicalMotion motion =
        run % 2 == 0 ? CanonicalMotion::kPressed : CanonicalMotion::kStroked;
    CanonicalHand hand(person, motion, display_Hz, radius_m);
    EXPECT_EQ(hand.start_scene_m(), stated_aim(person, motion, radius_m, 0.0));
    std::vector<double> pictures_s;
    double begun_s = -1.0;
    for (int n = 0; !hand.is_over(); ++n) {
      const double time_s = n * kTick_s;
      ASSERT_LT(time_s, 20.0);
      if (time_s >= static_cast<double>(pictures_s.size()) / display_Hz) {
        pictures_s.push_back(time_s);
      }
      const HandTarget target = hand.target(time_s, moving_pose(time_s), TickRecord{});
      double newest_s = -1.0;
      for (const double taken_s : pictures_s) {
        if (taken_s <= time_s - person.sight_delay_s) newest_s = taken_s;
      }
      if (newest_s < 0.0) {
        ASSERT_EQ(target.position_m, moving_pose(time_s).point(hand.start_scene_m()));
        ASSERT_EQ(target.velocity_m_per_s, Vec3(Vec3::Zero()));
        continue;
      }
      if (begun_s < 0.0) begun_s = time_s;
      const double s = time_s - begun_s;
      const Vec3 expected_m = moving_pose(newest_s).point(stated_aim(person, motion, radius_m, s));
      ASSERT_LT((target.position_m - expected_m).norm(), 1e-14) << "at " << s << " s";
      // The velocity is the derivative of the aim, away from its corners.
      const Vec3 before_m = stated_aim(person, motion, radius_m, s - 1e-4);
      const Vec3 after_m = stated_aim(person, motion, radius_m, s + 1e-4);
      const Vec3 middle_m = stated_aim(person, motion, radius_m, s);
      const bool is_straight = (after_m - 2.0 * middle_m + before_m).norm() < 1e-12;
      if (s <= 1e-4 || !is_straight) continue;
      const Vec3 slope = moving_pose(newest_s).direction((after_m - before_m) / 2e-4);
      ASSERT_LT((target.velocity_m_per_s - slope).norm(), 1e-9) << "at " << s << " s";
    }
    const double whole_s =
        motion == CanonicalMotion::kPressed ? 3.0 : 3.0 + 0.1 / person.speed_m_per_s;
    EXPECT_DOUBLE_EQ(canonical_duration_s(person, motion), whole_s);
  }
}

TEST(CanonicalHand, EndsWithTheMotion) {
  OperatorParameters person;
  person.sight_delay_s = 0.1;
  person.speed_m_per_s = 0.05;
  for (const auto& [motion, whole_s] :
       {std::pair(CanonicalMotion::kPressed, 3.0), std::pair(CanonicalMotion::kStroked, 5.0)}) {
    CanonicalHand hand(person, motion, 40.0, 0.0);
    int ticks = 0;
    while (!hand.is_over() && ticks < 10'000) {
      hand.target(ticks * kTick_s, moving_pose(0.0), TickRecord{});
      ++ticks;
    }
    // The picture of time 0 is seen 0.1 s later; one tick for the call that ends the motion, and
    // one for rounding.
    EXPECT_NEAR(ticks, (0.1 + whole_s) / kTick_s + 1.0, 1.0);
  }
}

// Without a display, the hand rests where it is, and the trial takes as long as the motion: at most
// four ticks more.
TEST(CanonicalTrial, EndsEvenIfThePersonSeesNoPicture) {
  const auto wall = canonical_wall(0.0);
  ASSERT_TRUE(wall.ok());
  OperatorParameters person;
  person.sight_delay_s = 0.1;
  person.speed_m_per_s = 0.05;
  for (const auto& [motion, whole_s] :
       {std::pair(CanonicalMotion::kPressed, 3.0), std::pair(CanonicalMotion::kStroked, 5.0)}) {
    const auto outcome =
        run_canonical_trial(*wall, device_setup(), 1e-310, person, {{30.0, motion, false}, 1});
    ASSERT_TRUE(outcome.ok()) << outcome.error().to_string();
    EXPECT_FALSE(outcome->along_over_into.has_value());
    EXPECT_FALSE(outcome->share_within_30deg.has_value());
    EXPECT_NEAR(static_cast<double>(outcome->ticks), (0.1 + whole_s) / kTick_s + 2.5, 2.5);
  }
}

class CanonicalPersons : public testing::TestWithParam<const char*> {
 protected:
  CanonicalPersons() {
    const auto file = load_operator(GetParam());
    EXPECT_TRUE(file.ok());
    file_ = *file;
    person_ = draw_person(file_, random_.seed(), 1 + static_cast<int>(random_.index(100)));
  }
  CanonicalConditions condition(double angle_deg, CanonicalMotion motion, bool rotates) {
    return {{angle_deg, motion, rotates}, random_.index(1'000'000)};
  }

  test::Random random_{3200};
  OperatorFile file_;
  OperatorParameters person_;
};

// f = (F.A1) A1 with F along N has the parts F cos^2 a into the hand and F |cos a sin a| along the
// wall, whatever the hand and its noise do.
TEST_P(CanonicalPersons, FeelTheTangentOfTheAngleWithoutRotation) {
  const auto wall = canonical_wall(0.0);
  ASSERT_TRUE(wall.ok());
  for (const double angle_deg : {0.0, 15.0, 30.0, 45.0, 60.0, 75.0}) {
    for (const CanonicalMotion motion : {CanonicalMotion::kPressed, CanonicalMotion::kStroked}) {
      const auto outcome = run_canonical_trial(*wall, device_setup(), 40.0, person_,
                                               condition(angle_deg, motion, false));
      ASSERT_TRUE(outcome.ok()) << outcome.error().to_string();
      EXPECT_FALSE(outcome->is_spoilt);
      ASSERT_TRUE(outcome->along_over_into.has_value());
      EXPECT_NEAR(*outcome->along_over_into, std::tan(angle_deg * kRadPerDeg), 1e-9);
      EXPECT_EQ(outcome->share_within_30deg, angle_deg <= 30.0 ? 1.0 : 0.0);
    }
  }
  const auto across = run_canonical_trial(*wall, device_setup(), 40.0, person_,
                                          condition(90.0, CanonicalMotion::kPressed, false));
  ASSERT_TRUE(across.ok());
  EXPECT_FALSE(across->along_over_into.has_value());
  EXPECT_EQ(across->share_within_30deg, 0.0);
}

// A4 turns the wall towards the motor: from beyond 30 deg the force along the wall becomes smaller
// and the share larger, and a stroke, which lasts longer, has more of both. Means of ten persons,
// because one may lose the wall again and again while it turns.
TEST_P(CanonicalPersons, FeelLessForceAlongTheWallWithRotation) {
  const auto wall = canonical_wall(0.0);
  ASSERT_TRUE(wall.ok());
  for (const double angle_deg : {45.0, 60.0, 75.0, 90.0}) {
    std::array<double, 2> ratio{}, share{};  // pressed and stroked
    constexpr int kPersons = 10;
    for (int i = 0; i < 2 * kPersons; ++i) {
      const auto motion = static_cast<CanonicalMotion>(i % 2);
      const auto outcome = run_canonical_trial(*wall, device_setup(), 40.0,
                                               draw_person(file_, random_.seed(), 1 + i / 2),
                                               condition(angle_deg, motion, true));
      ASSERT_TRUE(outcome.ok() && outcome->along_over_into && outcome->share_within_30deg);
      ratio[i % 2] += *outcome->along_over_into / kPersons;
      share[i % 2] += *outcome->share_within_30deg / kPersons;
    }
    EXPECT_LT(ratio[0], 0.5 * std::tan(angle_deg * kRadPerDeg));
    EXPECT_LT(ratio[1], ratio[0]);
    EXPECT_GT(share[0], 0.5);
    EXPECT_GT(share[1], share[0]);
  }
}

// Records the places that a device and a proxy come to.
class Reach final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    for (int k = 0; k < 2; ++k) {
      device_m = std::max(device_m, std::abs(record.device_m[k]));
    }
    along_m = std::max(along_m, std::abs(record.proxy_scene_m[1]));
    last_along_m = record.proxy_scene_m[1];
  }
  double device_m = 0.0;
  double along_m = 0.0;
  double last_along_m = 0.0;
};

TEST_P(CanonicalPersons, StayInTheWorkspaceAndOnTheWall) {
  const auto wall = canonical_wall(0.0);
  ASSERT_TRUE(wall.ok());
  for (int angle_deg = 0; angle_deg <= 90; angle_deg += 15) {
    for (const bool rotates : {false, true}) {
      const RunSetup setup = canonical_setup(device_setup(), angle_deg, rotates);
      CanonicalHand hand(person_, CanonicalMotion::kStroked, 40.0, 0.0);
      Reach reach;
      SimulatedDevice device =
          device_in_hand(plant_of(setup, person_, random_.index(1'000'000)), setup, hand,
                         setup.haptics.initial_pose.point(hand.start_scene_m()));
      const auto rig = Rig::create(*wall, setup, device, {.observers = {&reach, &device}});
      ASSERT_TRUE(rig.ok());
      run_simulated((*rig)->session(), setup.dt_s, 1'000'000,
                    [&](std::uint64_t) { return hand.is_over(); });
      EXPECT_LT(reach.device_m, 0.5 * workspace_extent_m(setup.device));
      EXPECT_LT(reach.along_m, kWallHalfLength_m);
      // The stroke is 100 mm less the lag and the noise of the hand, and the way that the ghost
      // force and the turning wall push it.
      EXPECT_NEAR(reach.last_along_m, kStroke_m, 0.03) << angle_deg << " deg " << rotates;
    }
  }
}

TEST_P(CanonicalPersons, DoTheSameToTheBit) {
  const auto wall = canonical_wall(3e-3);
  ASSERT_TRUE(wall.ok());
  const CanonicalConditions conditions = condition(60.0, CanonicalMotion::kStroked, true);
  const auto run = [&](const CanonicalConditions& c) {
    const auto outcome = run_canonical_trial(*wall, device_setup(3e-3), 40.0, person_, c);
    EXPECT_TRUE(outcome.ok());
    return std::tuple(outcome->along_over_into, outcome->share_within_30deg, outcome->ticks);
  };
  EXPECT_EQ(run(conditions), run(conditions));
  CanonicalConditions other = conditions;
  ++other.noise_seed;
  EXPECT_NE(run(conditions), run(other));
}

INSTANTIATE_TEST_SUITE_P(Files, CanonicalPersons, testing::Values("literature", "people2005"));

}  // namespace
}  // namespace palpate
