// The strategy cd: its work on a plane, and its drift.

#include "haptics/strategies/control_display.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kDeg;
using test::kTick_s;
using test::OwnedWorld;
using test::Random;

HapticSettings cd_settings() {
  HapticSettings settings;
  settings.coupling = {1000.0, 0.0};
  set_strategy(*parse_strategy("cd"), settings);
  return settings;
}

double drift_m(const HapticLoop& loop, const HapticSettings& settings) {
  return (loop.T_device_scene().translation_m - settings.initial_pose.translation_m).norm();
}

struct PressWork {
  double taken_J = 0.0;  // by the device while the hand presses
  double given_J = 0.0;  // to the hand while it releases
  double leak_J = 0.0;   // K/2 sum |dx|^2, of forces that are held for a tick
};

// Presses a plane at an angle to A1 along A1 from the first touch, and releases it.
PressWork press_and_release(double angle_rad, double depth_m, int steps) {
  const Vec3 normal(std::cos(angle_rad), std::sin(angle_rad), 0.0);
  const OwnedWorld world(test::sheet_soup(0.2, 0.2));
  HapticSettings settings = cd_settings();
  settings.initial_pose.rotation = turn_between(Vec3::UnitZ(), normal).normalized();
  auto loop =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), settings));
  PressWork work;
  Vec3 last_m = Vec3(1e-9, 0.0, 0.0);
  Vec3 force_N = vec3(loop.tick(last_m, kTick_s).force_device_N);
  for (int n = 1; n <= 2 * steps; ++n) {
    const double share = static_cast<double>(n <= steps ? n : 2 * steps - n) / steps;
    const Vec3 at_m = Vec3(1e-9 - depth_m * share, 0.0, 0.0);
    const double done_J = force_N.dot(at_m - last_m);
    (n <= steps ? work.taken_J : work.given_J) += n <= steps ? -done_J : done_J;
    work.leak_J += 0.5 * 1000.0 * (at_m - last_m).squaredNorm();
    force_N = vec3(loop.tick(at_m, kTick_s).force_device_N);
    last_m = at_m;
  }
  return work;
}

TEST(ControlDisplay, TakesMoreWorkThanItGives) {
  const PressWork work = press_and_release(40 * kDeg, 0.010, 20000);
  EXPECT_NEAR(work.taken_J, 23.46e-3, 0.01 * 23.46e-3);
  EXPECT_NEAR(work.given_J, 15.83e-3, 0.01 * 15.83e-3);
}

TEST(ControlDisplay, NeverGivesMoreThanItTookAlongTheMotor) {
  for (int angle_deg = 0; angle_deg <= 75; angle_deg += 5) {
    for (const double depth_m : {1e-4, 1e-3, 5e-3, 0.02}) {
      for (const int steps : {10, 100, 1000}) {
        const PressWork work = press_and_release(angle_deg * kDeg, depth_m, steps);
        const double rounding_J = 1e-12 * (work.taken_J + work.given_J);
        EXPECT_LE(work.given_J, work.taken_J + work.leak_J + rounding_J)
            << angle_deg << " deg, " << depth_m << " m, " << steps << " steps";
      }
    }
  }
}

// c from its definition.
TEST(ControlDisplayRatio, FollowsTheMissingForce) {
  Random random(61);
  for (int n = 0; n < 1000; ++n) {
    ControlDisplay cd;
    HandStep step;
    step.step_m = 1e-3 * random.unit_vector();
    step.was_in_contact = true;
    step.lag_m = 5e-3 * random.unit_vector();
    step.missing_N = random.uniform(0.0, 30.0) * random.unit_vector();
    cd.update(step);
    const double c = std::max(0.3, 1.0 / (1.0 + step.missing_N.norm() / 5.0));
    const Vec3 expected_m =
        step.step_m.dot(step.lag_m) < 0.0 ? Vec3((1.0 - c) * step.step_m) : Vec3(Vec3::Zero());
    EXPECT_EQ(cd.drift_m(), expected_m);
    step.was_in_contact = false;
    step.step_m = 1e-3 * random.unit_vector();
    cd.update(step);
    EXPECT_LE((cd.drift_m() - expected_m).norm(), 1e-4 * (1 + 1e-12));
    const double left_m = std::max(0.0, expected_m.norm() - 1e-4);
    EXPECT_NEAR(cd.drift_m().norm(), left_m, 1e-17);
  }
}

// A hand that wanders in and out of a box. The drift stays within 30 mm; where it would not, the
// scene does not follow. In free motion it returns to exactly the place at the start.
TEST(ControlDisplayDrift, StaysWithinItsLimitAndReturns) {
  const int ticks = test::in_soak_or_else(1'000'000, 50'000);
  Random random(62);
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  const HapticSettings settings = cd_settings();
  auto loop =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), settings));
  Vec3 at_m(0.15, 0.0, 0.0);
  Vec3 aim_m = at_m;
  double worst_m = 0.0;
  double last_m = 0.0;
  bool was_in_contact = false;
  int contacts = 0;
  Vec3 proxy_m = at_m;  // device frame
  for (int n = 0; n < ticks; ++n) {
    if (random.index(200) == 0) aim_m = random.uniform(0.05, 0.2) * random.unit_vector();
    const Vec3 step_m = 0.02 * (aim_m - at_m) + random.in_box(1e-4);
    at_m += step_m;
    const TickRecord& record = loop.tick(at_m, kTick_s);
    const double now_m = drift_m(loop, settings);
    worst_m = std::max(worst_m, now_m);
    // A step in free motion, from the second good tick on.
    if (n > 0 && !was_in_contact) {
      ASSERT_GE(now_m, last_m - 0.1 * step_m.norm() * (1 + 1e-9) - 1e-15) << "tick " << n;
      ASSERT_LE(now_m, last_m + 1e-15) << "tick " << n;
    }
    was_in_contact = record.contact != 0;
    contacts += record.contact;
    last_m = now_m;
    proxy_m = pose_after(record).point(vec3(record.proxy_scene_m));
  }
  EXPECT_LE(worst_m, ControlDisplay::kMostDrift_m * (1 + 1e-12));
  EXPECT_GT(worst_m, 0.5 * ControlDisplay::kMostDrift_m);
  EXPECT_GT(contacts, ticks / 10);
  // Out of the box on the proxy's side, and to and fro over 0.4 m in all, which is more than ten
  // times the drift.
  const Vec3 out = proxy_m.normalized();
  for (int n = 0; n < 4000; ++n) {
    loop.tick((0.3 + 1e-4 * (n % 2)) * out, kTick_s);
  }
  EXPECT_EQ(drift_m(loop, settings), 0.0);
}

// The record's pose before the elementary rotation is that of its goal.
TEST(ControlDisplay, RecordsThePoseOfItsGoal) {
  Random random(63);
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  auto loop = test::made(
      HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), cd_settings()));
  Vec3 at_m(0.15, 0.0, 0.0);
  for (int n = 0; n < 3000; ++n) {
    at_m += 0.01 * (0.05 * random.unit_vector() - at_m);
    const TickRecord& record = loop.tick(at_m, kTick_s);
    const Vec3 goal_m = pose_before(record).inverse_point(vec3(record.device_m));
    ASSERT_LE((goal_m - vec3(record.goal_scene_m)).norm(), 8 * 0x1p-52);
    ASSERT_EQ(vec3(record.o_before_m), vec3(record.o_after_m));
  }
}

}  // namespace
}  // namespace palpate
