// The hard cases of A4: corners, loss of contact, and the work of a force of which the device can
// apply only a component. JudgedLoop judges each tick.

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"
#include "tests/engine/session/hard_case_device.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::device;
using test::device_name;
using test::facing;
using test::HardDevice;
using test::JudgedLoop;
using test::kDeg;
using test::kTick_s;
using test::OwnedWorld;
using test::posed;
using test::Random;
using test::settings;
using test::trials;

// ---- 18 A4 in corners and at the loss of contact -----------------------------------------------

class HardCase18_A4 : public testing::TestWithParam<HardDevice> {
 protected:
  // Presses and holds still. The spring must not gain energy while the scene turns.
  static void hold(JudgedLoop& loop, const Vec3& at_m, int ticks) {
    TickRecord last = loop.tick(at_m, kTick_s);
    for (int n = 0; n < ticks; ++n) {
      const TickRecord now = loop.tick(at_m, kTick_s);
      const double lag_m = (vec3(now.proxy_scene_m) - vec3(now.goal_scene_m)).norm();
      const double lag_before_m = (vec3(last.proxy_scene_m) - vec3(last.goal_scene_m)).norm();
      // The pivot keeps its position to 2 ulp of the coordinates.
      const double rounding_m =
          8 * 0x1p-52 * (vec3(now.goal_scene_m).norm() + vec3(now.device_m).norm());
      ASSERT_LE(lag_m, lag_before_m * (1 + 1e-12) + rounding_m) << "tick " << n;
      ASSERT_TRUE(now.contact);
      last = now;
    }
    ASSERT_EQ(loop.verdict(), "");
  }
  // A device with two sensors stays in its plane, so that the corner must lie in that plane.
  static RigidTransform pose_for(int sensors, Random& random) {
    if (sensors == 3) return random.pose(0.5);
    const Quat turn(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vec3::UnitZ()));
    return {turn, random.in_box(0.5).cwiseProduct(Vec3(1, 1, 0))};
  }
};

// The hand presses into a concave corner of two or three walls and holds. A4 receives the mean
// normal of the walls.
TEST_P(HardCase18_A4, AddsNoEnergyToTheSpringInACorner) {
  const auto [sensors, actuators, radius] = GetParam();
  Random random(307);
  for (int n = 0; n < trials(20); ++n) {
    const RigidTransform pose = pose_for(sensors, random);
    const OwnedWorld world(posed(test::box_soup({0.1, 0.08, 0.06}), pose), {}, radius);
    JudgedLoop loop(world, device(sensors, actuators), settings(1000.0, 2.0, true, radius));
    loop.tick(pose.point(Vec3::Zero()), kTick_s);
    const double z = sensors == 3 && n % 2 ? 0.08 : 0.0;
    ASSERT_NO_FATAL_FAILURE(hold(loop, pose.point({0.11, 0.09, z}), 3000)) << "pose " << n;
  }
}

TEST_P(HardCase18_A4, AddsNoEnergyToTheSpringInThePapersCorners) {
  const auto [sensors, actuators, radius] = GetParam();
  Random random(308);
  for (const PaperObject& object : paper_objects()) {
    const RigidTransform pose = pose_for(2, random);
    const Contour& contour = object.contour_m;
    const OwnedWorld world(posed(test::paper_object_soup(object), pose), {}, radius);
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const auto at = [&](std::size_t k) {
        const Point2& c = contour[k % contour.size()];
        return Vec3(c.x(), c.y(), 0.0);
      };
      const Vec3 in = (at(i + 1) - at(i)).normalized();
      const Vec3 out = (at(i + 2) - at(i + 1)).normalized();
      if (in.cross(out).z() >= 0.0) continue;  // a convex corner
      const Vec3 bisector = (out - in).normalized();
      JudgedLoop loop(world, device(sensors, actuators), settings(1000.0, 2.0, true, radius));
      loop.tick(pose.point(at(i + 1) + (2 * radius + 5e-3) * bisector), kTick_s);
      const Vec3 aside = Vec3::UnitZ().cross(bisector);
      for (const double slant : {-0.5, 0.0, 0.5}) {
        const Vec3 pressed = at(i + 1) - 2e-3 * (bisector + slant * aside);
        ASSERT_NO_FATAL_FAILURE(hold(loop, pose.point(pressed), 300)) << object.name;
      }
    }
  }
}

// The scene turns while contact lasts. From the tick that loses contact on, the pose keeps its
// bits; the next contact turns it again.
TEST_P(HardCase18_A4, StopsTurningWithTheContact) {
  const auto [sensors, actuators, radius] = GetParam();
  Random random(309);
  const Vec3 normal =
      actuators == 2 ? Vec3(0.2, 0.1, 0.97).normalized() : Vec3(0.3, 0.95, 0.0).normalized();
  const OwnedWorld world(posed(test::sheet_soup(1.0, 1.0), facing(normal, {0, 0, 0}, random)), {},
                         radius);
  JudgedLoop loop(world, device(sensors, actuators), settings(1000.0, 2.0, true, radius));
  loop.tick((radius + 0.01) * normal, kTick_s);
  int losses = 0;
  bool was_in_contact = false;
  for (int n = 0; n < 2000; ++n) {
    const ScenePose before = loop.T_device_scene();
    const double height = radius + 4e-3 * std::sin(0.05 * n);
    const TickRecord record = loop.tick(height * normal, kTick_s);
    const bool same = before.rotation.coeffs() == loop.T_device_scene().rotation.coeffs() &&
                      before.translation_m == loop.T_device_scene().translation_m;
    ASSERT_EQ(same, !record.contact || record.alpha_rad == 0.0) << "tick " << n;
    losses += was_in_contact && !record.contact;
    was_in_contact = record.contact;
  }
  EXPECT_GT(losses, 5);
  EXPECT_EQ(loop.verdict(), "");
}

INSTANTIATE_TEST_SUITE_P(Devices, HardCase18_A4,
                         testing::Values(HardDevice{3, 1, 0.0}, HardDevice{3, 2, 0.0},
                                         HardDevice{2, 1, 0.0}, HardDevice{3, 1, 2e-3},
                                         HardDevice{3, 2, 2e-3}, HardDevice{2, 1, 2e-3}),
                         device_name);

// ---- 19 work along a closed loop ---------------------------------------------------------------

class HardCase19_UnderActuatedLoop : public testing::TestWithParam<double> {
 protected:
  static constexpr double kStiffness = 1000.0;
  static constexpr double kQuick_s = 1e-9;  // no time for the scene to turn
  static constexpr double kSide_m = 5e-3;
  static constexpr int kSteps = 4000;

  // The work of the port along a square in two directions, with each force held for one step.
  static double work_J(JudgedLoop& loop, const Vec3& at_m, const Vec3& u, const Vec3& v) {
    const Vec3 corners[5] = {at_m, at_m + kSide_m * u, at_m + kSide_m * (u + v), at_m + kSide_m * v,
                             at_m};
    Vec3 force_N = vec3(loop.tick(at_m, kQuick_s).force_device_N);
    Vec3 from = at_m;
    double work = 0.0;
    for (int side = 0; side < 4; ++side) {
      for (int i = 1; i <= kSteps; ++i) {
        const double part = static_cast<double>(i) / kSteps;
        const Vec3 to = corners[side] + part * (corners[side + 1] - corners[side]);
        work += force_N.dot(to - from);
        force_N = vec3(loop.tick(to, kQuick_s).force_device_N);
        from = to;
      }
    }
    return work;
  }
};

// The wall of a box in a random pose is pressed at 75 deg to the single actuator. The work is
// W = K A sin a cos a for every contact angle a, until the scene is aligned and the work vanishes.
TEST_P(HardCase19_UnderActuatedLoop, DoesTheWorkOfTheRemainingAngle) {
  const double radius = GetParam();
  Random random(310);
  for (int n = 0; n < 4; ++n) {
    const Vec3 a1 = Vec3::UnitX();
    Vec3 tangent = random.unit_vector();
    tangent = (tangent - tangent.dot(a1) * a1).normalized();
    const Vec3 normal = std::cos(75 * kDeg) * a1 + std::sin(75 * kDeg) * tangent;
    const RigidTransform pose = facing(normal, random.in_box(0.1), random);
    const OwnedWorld world(posed(test::box_soup({0.4, 0.4, 0.2}), pose), {}, radius);
    HapticSettings s = settings(kStiffness, 0.0, true, radius);
    s.force = ForceMode::kActuated;
    JudgedLoop loop(world, device(3, 1), s);
    const Vec3 top = pose.point({0.0, 0.0, 0.2 + radius});
    const Vec3 at_m = top - 0.012 * normal;  // deeper than the loop is wide
    loop.tick(top + 0.01 * normal, kTick_s);
    loop.tick(at_m, kQuick_s);
    const double whole_J = kStiffness * kSide_m * kSide_m;
    double left_rad = 0.0;
    for (int hold = 0; hold < 8; ++hold) {
      const TickRecord record = loop.tick(at_m, kQuick_s);
      const double angle = record.alpha_rad;
      // A loop in the plane of the actuator and the present normal.
      const Vec3 now = loop.T_device_scene().direction(vec3(record.normal_scene));
      const Vec3 across = now - now.dot(a1) * a1;
      const Vec3 v = across.norm() > 1e-9 ? Vec3(across.normalized()) : tangent;
      const double expected_J = whole_J * std::sin(angle) * std::cos(angle);
      // The extra work of a held force beyond the integral: K/2 dx^2 per step.
      const double held_J = 0.5 * 4 * whole_J / kSteps;
      ASSERT_NEAR(work_J(loop, at_m, a1, v), expected_J, 0.01 * std::abs(expected_J) + held_J)
          << angle / kDeg << " deg";
      left_rad = angle;
      for (int tick = 0; tick < 250; ++tick) loop.tick(at_m, kTick_s);
    }
    ASSERT_LT(left_rad, 1e-9);
    ASSERT_EQ(loop.verdict(), "") << "pose " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase19_UnderActuatedLoop, testing::Values(0.0, 5e-3),
                         [](const auto& radius_m) {
                           return radius_m.param == 0.0 ? "Point" : "Sphere";
                         });

}  // namespace
}  // namespace palpate
