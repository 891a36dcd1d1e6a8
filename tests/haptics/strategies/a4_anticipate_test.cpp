// The strategy a4-anticipate: when it turns, how far it has turned at the touch, and what a turn
// leaves as it was.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kDeg;
using test::kTick_s;
using test::OwnedWorld;
using test::Random;

HapticSettings anticipating(double range_m = AnticipationSettings{}.range_m) {
  HapticSettings settings;
  set_strategy(*parse_strategy("a4-anticipate"), settings);
  settings.anticipation.range_m = range_m;
  return settings;
}

// T = max(a - 30, 0)/90 + (6/17) ln((5 + k min(a, 30))/5), k = 85/30, in degrees and seconds.
TEST(AlignmentTime, IsThatOfTheProfile) {
  const RotationProfile profile;
  EXPECT_NEAR(alignment_time_s(profile, 90 * kDeg), 1.686798, 5e-7);
  EXPECT_NEAR(alignment_time_s(profile, 60 * kDeg), 1.353465, 5e-7);
  EXPECT_NEAR(alignment_time_s(profile, 30 * kDeg), 1.020131, 5e-7);
  EXPECT_NEAR(alignment_time_s(profile, 10 * kDeg), 0.669572, 5e-7);
  EXPECT_EQ(alignment_time_s(profile, 0.0), 0.0);
}

TEST(AlignmentTime, IsTheTimeAfterWhichNoAngleIsLeft) {
  Random random(51);
  for (int n = 0; n < 1000; ++n) {
    RotationProfile profile;
    profile.speed_at_zero_rad_per_s = random.uniform(0.01, 3.0);
    profile.speed_at_knee_rad_per_s =
        n % 10 == 0 ? profile.speed_at_zero_rad_per_s : random.uniform(0.01, 3.0);
    profile.knee_rad = random.uniform(0.1, 1.5);
    const double angle_rad = random.uniform(0.0, std::numbers::pi);
    const double whole_s = alignment_time_s(profile, angle_rad);
    const auto left_rad = [&](double dt_s) {
      return angle_rad - elementary_rotation_rad(profile, StepRule::kExact, angle_rad, dt_s);
    };
    // A time error of one part in 1e12 leaves that part of the fastest turn.
    EXPECT_LE(left_rad(whole_s * (1 + 1e-12)), 1e-12);
    EXPECT_GE(left_rad(whole_s * (1 - 1e-3)), 0.0);
    EXPECT_GT(left_rad(whole_s * 0.99), 0.0);
  }
}

// A large wall whose normal makes an angle with the motor A1, and a hand that approaches along the
// normal as the picture turns.
class Approach {
 public:
  Approach(Random& random, const ActuationModel& device, double angle_rad,
           const HapticSettings& settings)
      : world_(test::sheet_soup(0.5, 0.5)) {
    const Vec3 a1 = device.actuated_axis(0);
    Vec3 across = device.is_planar() ? Vec3(Vec3::UnitY()) : random.unit_vector();
    across = (across - across.dot(a1) * a1).normalized();
    const Vec3 normal = std::cos(angle_rad) * a1 + std::sin(angle_rad) * across;
    HapticSettings placed = settings;
    placed.initial_pose.rotation = turn_between(Vec3::UnitZ(), normal).normalized();
    placed.initial_pose.translation_m =
        device.is_planar() ? Vec3(Vec3::Zero()) : random.in_box(0.02);
    loop_ = test::made(HapticLoop::create(world_.world(), device, placed));
    device_m_ = placed.initial_pose.translation_m;
  }

  // The normal in the device frame, as the display shows it now.
  Vec3 normal() const { return loop_->T_device_scene().direction(Vec3::UnitZ()); }

  // The first tick: at a height above the wall.
  void begin_at(double height_m) {
    device_m_ += height_m * normal();
    loop_->tick(device_m_, kTick_s);
  }
  // Moves along the normal, towards the wall if the speed is positive.
  const TickRecord& tick(double speed_m_per_s) {
    device_m_ -= speed_m_per_s * kTick_s * normal();
    return loop_->tick(device_m_, kTick_s);
  }
  HapticLoop& loop() { return *loop_; }
  Vec3& device_m() { return device_m_; }

 private:
  OwnedWorld world_;
  std::optional<HapticLoop> loop_;
  Vec3 device_m_ = Vec3::Zero();
};

ActuationModel device(int sensors, int actuators) {
  return *ActuationModel::from_counts(sensors, actuators);
}

struct Touch {
  double alpha_rad = -1.0;
  double begun_at_m = 0.0;  // the height at which turning began
  int turns = 0;            // ticks in free motion that turned
};

Touch touch(Approach& approach, double from_m, double speed_m_per_s) {
  Touch result;
  approach.begin_at(from_m);
  double height_m = from_m;
  for (int n = 0; n < 100000; ++n) {
    const TickRecord& record = approach.tick(speed_m_per_s);
    height_m -= speed_m_per_s * kTick_s;
    if (record.contact) {
      result.alpha_rad = record.alpha_rad;
      return result;
    }
    if (record.rotation_rad > 0.0 && result.turns++ == 0) result.begun_at_m = height_m;
  }
  return result;
}

// 60 deg take 1.353465 s, in which a hand at 10 mm/s covers 13.53465 mm.
TEST(Anticipation, EndsWithTheTouch) {
  Random random(52);
  for (int trial = 0; trial < 10; ++trial) {
    Approach approach(random, device(trial % 2 ? 3 : 2, 1), 60 * kDeg, anticipating());
    const double from_m = 0.025 + random.uniform(0.0, 1e-4);
    const Touch result = touch(approach, from_m, 0.010);
    EXPECT_LT(result.alpha_rad / kDeg, 0.01) << "trial " << trial;
    EXPECT_GE(result.alpha_rad, 0.0);
    EXPECT_LE(result.begun_at_m, 13.53465e-3 + 1e-8);
    EXPECT_GE(result.begun_at_m, 13.53465e-3 - 1.01e-5);
  }
}

// With two motors, the angle is that to their plane.
TEST(Anticipation, TurnsIntoThePlaneOfTwoMotors) {
  const OwnedWorld world(test::sheet_soup(0.5, 0.5));
  HapticSettings settings = anticipating();
  // The normal is 60 deg from the plane of A1 and A2.
  const Vec3 normal(std::cos(60 * kDeg), 0.0, std::sin(60 * kDeg));
  settings.initial_pose.rotation = turn_between(Vec3::UnitZ(), normal).normalized();
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 2), settings));
  const auto shown = [&] { return loop.T_device_scene().direction(Vec3::UnitZ()); };
  Vec3 at_m = 0.025 * shown();
  TickRecord record = loop.tick(at_m, kTick_s);
  while (!record.contact) {
    at_m -= 1e-5 * shown();
    record = loop.tick(at_m, kTick_s);
  }
  EXPECT_LT(record.alpha_rad / kDeg, 0.01);
}

// With a range of 15 mm, a hand at 20 mm/s turns for 0.75 s: from 60 deg to 7.9905 deg.
TEST(Anticipation, LeavesTheAngleThatTheRangeLeaves) {
  Random random(53);
  for (int trial = 0; trial < 10; ++trial) {
    Approach approach(random, device(trial % 2 ? 3 : 2, 1), 60 * kDeg, anticipating(0.015));
    // 100 ticks of 20 um, and a height that is just within the range.
    const double from_m = 0.015 + 100 * 20e-6 - 1e-8;
    const Touch result = touch(approach, from_m, 0.020);
    EXPECT_NEAR(result.alpha_rad / kDeg, 7.9905, 0.01) << "trial " << trial;
    EXPECT_EQ(result.turns, 750);
  }
}

// In contact, the strategy is A4: a hand that touches without an approach gives the same bits.
TEST(Anticipation, IsA4InContact) {
  Random random(54);
  HapticSettings a4;
  Approach one(random, device(3, 1), 60 * kDeg, anticipating());
  Random again(54);
  Approach other(again, device(3, 1), 60 * kDeg, a4);
  for (Approach* approach : {&one, &other}) approach->begin_at(0.025);
  int turned = 0;
  for (int n = 0; n < 1500; ++n) {
    const double to_m = n < 5 ? 0.0252 : -3e-3;  // out of range, then pressed at once
    const Vec3 at_m = one.device_m() + (to_m - 0.025) * one.normal();
    const TickRecord record = one.loop().tick(at_m, kTick_s);
    const TickRecord& expected = other.loop().tick(at_m, kTick_s);
    ASSERT_EQ(vec3(record.force_device_N), vec3(expected.force_device_N)) << "tick " << n;
    ASSERT_EQ(record.rotation_rad, expected.rotation_rad);
    turned += record.contact && record.rotation_rad > 0.0;
  }
  EXPECT_GT(turned, 100);
}

// An encoder step of 20 um in one tick would be 20 mm/s; over 20 ms it is 1 mm/s along each axis.
TEST(Anticipation, DoesNotTurnForAHandAtRestWithEncoderNoise) {
  Random random(55);
  for (int trial = 0; trial < 40; ++trial) {
    Approach approach(random, device(trial % 2 ? 3 : 2, 1), random.uniform(0.1, 1.5),
                      anticipating());
    approach.begin_at(random.uniform(0.5e-3, 0.019));
    const Vec3 at_m = approach.device_m();
    for (int n = 0; n < 2000; ++n) {
      const Vec3 step(random.index(2) ? 20e-6 : 0.0, random.index(2) ? 20e-6 : 0.0,
                      random.index(2) ? 20e-6 : 0.0);
      const TickRecord& record = approach.loop().tick(at_m + step, kTick_s);
      ASSERT_EQ(record.rotation_rad, 0.0) << "trial " << trial << ", tick " << n;
      ASSERT_EQ(record.contact, 0u);
    }
  }
}

// A hand that slides along a wall and comes nearer by less than 2 mm/s touches before it turns.
TEST(Anticipation, DoesNotTurnForASlowApproachOfAFastHand) {
  Random random(50);
  for (int trial = 0; trial < 20; ++trial) {
    Approach approach(random, device(3, 1), random.uniform(0.3, 1.5), anticipating());
    approach.begin_at(3e-3);
    const Vec3 aside = approach.normal().unitOrthogonal();
    for (int n = 0; n < 10000; ++n) {
      approach.device_m() += kTick_s * 0.05 * aside;
      const TickRecord& record = approach.tick(1.9e-3);
      if (record.contact) break;
      ASSERT_EQ(record.rotation_rad, 0.0) << "trial " << trial << ", tick " << n;
    }
  }
}

TEST(Anticipation, DoesNotTurnForAHandThatMovesAway) {
  Random random(56);
  for (int trial = 0; trial < 40; ++trial) {
    Approach approach(random, device(3, 1), random.uniform(0.1, 1.5), anticipating());
    approach.begin_at(random.uniform(0.5e-3, 0.010));
    const double speed_m_per_s = random.uniform(1e-3, 0.2);
    Vec3 aside = random.unit_vector();
    aside -= aside.dot(approach.normal()) * approach.normal();
    for (int n = 0; n < 300; ++n) {
      approach.device_m() += kTick_s * random.uniform(0.0, 0.1) * aside;
      ASSERT_EQ(approach.tick(-speed_m_per_s).rotation_rad, 0.0) << "trial " << trial;
    }
  }
}

// A hand that stops before the wall ends the turn; the scene stays.
TEST(Anticipation, EndsWhenTheHandTurnsBack) {
  Random random(57);
  Approach approach(random, device(3, 1), 60 * kDeg, anticipating());
  approach.begin_at(0.025);
  int turns = 0;
  for (int n = 0; n < 1600; ++n) turns += approach.tick(0.010).rotation_rad > 0.0;
  ASSERT_GT(turns, 100);
  for (int n = 0; n < 25; ++n) approach.tick(-0.010);  // longer than the window of the velocity
  for (int n = 0; n < 500; ++n) ASSERT_EQ(approach.tick(-0.010).rotation_rad, 0.0) << n;
}

// A tick without work left for the search, or without a good sample, does not turn.
TEST(Anticipation, NeedsWorkAndAGoodSample) {
  Random random(58);
  HapticSettings settings = anticipating();
  settings.god_object.accuracy.work_budget = 1;
  Approach poor(random, device(3, 1), 60 * kDeg, settings);
  poor.begin_at(0.025);
  for (int n = 0; n < 2400; ++n) ASSERT_EQ(poor.tick(0.010).rotation_rad, 0.0);

  Approach approach(random, device(3, 1), 60 * kDeg, anticipating());
  approach.begin_at(0.025);
  int turns = 0;
  for (int n = 0; n < 1600; ++n) {
    if (n % 50 == 49) {
      approach.loop().refuse_sample();
      ASSERT_EQ(approach.tick(0.010).rotation_rad, 0.0);
      // The velocity is unknown until good samples span the window again.
      for (int k = 0; k < 19; ++k) ASSERT_EQ(approach.tick(0.010).rotation_rad, 0.0);
    }
    turns += approach.tick(0.010).rotation_rad > 0.0;
  }
  EXPECT_GT(turns, 100);
}

// The device point in a scene at this pose, evaluated in long double and rounded once.
Vec3 goal_in(const ScenePose& pose, const Vec3& device_m) {
  const Eigen::Quaternion<long double> q = pose.rotation.cast<long double>().normalized();
  const auto from_origin_m =
      (device_m.cast<long double>() - pose.translation_m.cast<long double>()).eval();
  return (q.conjugate() * from_origin_m).cast<double>();
}

// The device point keeps its place in the scene, and a potential of the scene its value.
TEST(Anticipation, KeepsTheGoalAndThePotentialOfFields) {
  Random random(59);
  int turns = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Approach approach(random, device(trial % 2 ? 3 : 2, 1), random.uniform(0.3, 1.5),
                      anticipating());
    const Vec3 source_m = random.in_box(0.05);
    const auto potential_J = [&](const Vec3& p_m) {
      return 0.5 * 1000.0 * (p_m - source_m).squaredNorm();
    };
    approach.begin_at(0.025);
    for (int n = 0; n < 2000; ++n) {
      const TickRecord& record = approach.tick(0.010);
      if (record.contact) break;
      if (record.rotation_rad == 0.0) continue;
      ++turns;
      const Vec3 device_m = vec3(record.device_m);
      const Vec3 before_m = vec3(record.goal_scene_m);
      const Vec3 after_m = goal_in(pose_after(record), device_m);
      // An ulp is that of the longest vector from which the goal is computed.
      const double size_m =
          std::max({device_m.norm(), vec3(record.o_before_m).norm(), before_m.norm()});
      ASSERT_LE((after_m - before_m).norm(), 4 * 0x1p-52 * size_m);
      ASSERT_LE(std::abs(potential_J(after_m) - potential_J(before_m)), 1e-12);
      ASSERT_EQ(vec3(record.proxy_scene_m), vec3(record.goal_scene_m));
    }
  }
  EXPECT_GT(turns, 5000);
}

}  // namespace
}  // namespace palpate
