#include "haptics/a4/scene_pose.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kEpsilon;
using test::Random;

// The error relative to the lengths involved: three rotations of a vector, each of about two
// roundings, and two sums.
constexpr double kPivotRoundoff = 1e-15;
constexpr int kManySteps = 1'000'000;

// The largest elementary rotation of a tick at 1 kHz.
constexpr double kLargestStep_rad = 90.0 * std::numbers::pi / 180.0 * 1e-3;

AxisAngle random_turn(Random& random, double max_angle_rad) {
  const Vec3 axis = random.unit_vector();
  return {axis, random.uniform(0.0, max_angle_rad)};
}

double angle_between_rad(const Quat& a, const Quat& b) {
  const Quat difference = a * b.conjugate();
  return 2.0 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

// The motion of the pivot by turns of up to max_angle_rad, relative to the lengths involved.
double worst_pivot_motion(Random& random, double max_angle_rad) {
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const double size_m = std::pow(10.0, random.uniform(-3.0, 3.0));
    const ScenePose pose = random.pose(size_m);
    const Vec3 pivot_scene_m = random.in_box(size_m);
    const ScenePose turned = turned_about(pose, pivot_scene_m, random_turn(random, max_angle_rad));
    const double moved_m = (turned.point(pivot_scene_m) - pose.point(pivot_scene_m)).norm();
    worst = std::max(worst, moved_m / (pivot_scene_m.norm() + pose.translation_m.norm()));
  }
  return worst;
}

TEST(ScenePose, KeepsThePivotInPlaceInTheDeviceFrame) {
  Random random(3301);
  EXPECT_LE(worst_pivot_motion(random, kLargestStep_rad), kPivotRoundoff);
  EXPECT_LE(worst_pivot_motion(random, std::numbers::pi), kPivotRoundoff);
}

TEST(ScenePose, TurnsTheSceneByTheRotationOfTheDeviceFrame) {
  Random random(3302);
  for (int i = 0; i < 10000; ++i) {
    const ScenePose pose = random.pose(1.0);
    const Vec3 pivot_scene_m = random.in_box(1.0);
    const Vec3 p_scene_m = random.in_box(1.0);
    const AxisAngle turn = random_turn(random, std::numbers::pi);
    // Rodrigues' formula on the arm from the pivot, in the device frame.
    const Vec3 arm = pose.direction(p_scene_m - pivot_scene_m);
    const Vec3& k = turn.axis_device;
    const Vec3 turned_arm = arm * std::cos(turn.angle_rad) +
                            k.cross(arm) * std::sin(turn.angle_rad) +
                            k * k.dot(arm) * (1.0 - std::cos(turn.angle_rad));
    const Vec3 expected = pose.point(pivot_scene_m) + turned_arm;
    const ScenePose turned = turned_about(pose, pivot_scene_m, turn);
    ASSERT_LE((turned.point(p_scene_m) - expected).norm(), 64 * kEpsilon);
  }
}

TEST(ScenePose, ATurnByZeroChangesOnlyRounding) {
  Random random(3303);
  const ScenePose pose = random.pose(1.0);
  const ScenePose turned = turned_about(pose, random.in_box(1.0), AxisAngle{});
  EXPECT_LE(angle_between_rad(turned.rotation, pose.rotation), 4 * kEpsilon);
  EXPECT_LE((turned.translation_m - pose.translation_m).norm(), 4 * kEpsilon);
}

TEST(ScenePose, QuaternionKeepsUnitLengthOverAMillionSteps) {
  Random random(3304);
  ScenePose pose = random.pose(0.1);
  double worst = 0.0;
  for (int i = 0; i < kManySteps; ++i) {
    pose = turned_about(pose, random.in_box(0.1), random_turn(random, kLargestStep_rad));
    worst = std::max(worst, std::abs(pose.rotation.norm() - 1.0));
  }
  EXPECT_LE(worst, 4 * kEpsilon);
}

// The requirement is 1e-6 rad over 1e9 steps; drift grows at most in proportion to the steps.
TEST(ScenePose, ReturnsAfterAMillionStepsForwardAndBack) {
  Random random(3305);
  const ScenePose start = random.pose(0.1);
  std::vector<std::pair<Vec3, AxisAngle>> turns;
  for (int i = 0; i < kManySteps; ++i) {
    turns.emplace_back(random.in_box(0.1), random_turn(random, kLargestStep_rad));
  }
  ScenePose pose = start;
  for (const auto& [pivot_scene_m, turn] : turns) pose = turned_about(pose, pivot_scene_m, turn);
  EXPECT_GT(angle_between_rad(pose.rotation, start.rotation), 0.1);
  for (auto turn = turns.rbegin(); turn != turns.rend(); ++turn) {
    pose = turned_about(pose, turn->first, {turn->second.axis_device, -turn->second.angle_rad});
  }
  EXPECT_LE(angle_between_rad(pose.rotation, start.rotation), 1e-6 * (kManySteps / 1e9));
  EXPECT_LE((pose.translation_m - start.translation_m).norm(), 1e-6 * (kManySteps / 1e9));
}

TEST(DisplayTransform, ClassicalModeShowsTheDeviceFrame) {
  Random random(3306);
  const ScenePose pose = random.pose(1.0);
  const RigidTransform shown = display_transform(DisplayMode::kClassical, pose, random.in_box(1.0));
  EXPECT_EQ(shown.rotation.coeffs(), pose.rotation.coeffs());
  EXPECT_EQ(shown.translation_m, pose.translation_m);
}

TEST(DisplayTransform, CameraKeepsTheProxyAtTheCentre) {
  Random random(3307);
  for (int i = 0; i < 10000; ++i) {
    const ScenePose pose = random.pose(1.0);
    const Vec3 proxy_scene_m = random.in_box(1.0);
    const RigidTransform shown = display_transform(DisplayMode::kCamera, pose, proxy_scene_m);
    ASSERT_LE(shown.point(proxy_scene_m).norm(), kEpsilon * proxy_scene_m.norm());
    ASSERT_EQ(shown.rotation.coeffs(), pose.rotation.coeffs()) << "only the translation differs";
  }
}

// To = 0, Ts = -Tu: the scene moves opposite to the user's motion, and the proxy does not move.
TEST(DisplayTransform, CameraMovesTheSceneAgainstTheUser) {
  Random random(3308);
  const ScenePose pose = random.pose(1.0);
  const Vec3 p_scene_m = random.in_box(1.0);
  const Vec3 proxy_scene_m = random.in_box(1.0);
  const Vec3 motion_scene_m = random.in_box(0.1);
  const auto shown_at = [&](const Vec3& proxy) {
    return display_transform(DisplayMode::kCamera, pose, proxy).point(p_scene_m);
  };
  const Vec3 moved = shown_at(proxy_scene_m + motion_scene_m) - shown_at(proxy_scene_m);
  EXPECT_LE((moved + pose.direction(motion_scene_m)).norm(), 16 * kEpsilon);
}

}  // namespace
}  // namespace palpate
