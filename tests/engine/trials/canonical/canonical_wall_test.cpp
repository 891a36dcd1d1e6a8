// The canonical wall, touched by a device that moves on a given path: the ratio of forces is tan a,
// and A4 brings the contact angle to 30 deg in the time that Figure 3 states. The walls, normals
// and forces of the oracles are computed here, from the definition alone.

#include "engine/trials/canonical/canonical_wall.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/rig/replay.h"
#include "engine/trials/canonical/canonical_measures.h"
#include "haptics/proxy/contact_world.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDepth_m = 8e-3;
constexpr double kOutside_m = 16e-3;

Vec3 direction_in_plane(double rad) {
  return {std::cos(rad), std::sin(rad), 0.0};
}

// A wall at an angle to a motor that has any direction in the plane of the sensors.
class GivenWall {
 public:
  GivenWall(test::Random& random, double angle_deg, bool rotates)
      : GivenWall(random, angle_deg, rotates, random.uniform(0.0, 10e-3)) {}
  GivenWall(test::Random& random, double angle_deg, bool rotates, double radius_m)
      : motor_rad_(random.uniform(-std::numbers::pi, std::numbers::pi)),
        radius_m_(radius_m),
        wall_(canonical_wall(radius_m_)) {
    EXPECT_TRUE(wall_.ok());
    RunSettings settings;
    settings.sensors = 2;
    settings.actuated_axes = {direction_in_plane(motor_rad_)};
    settings.haptics.god_object.radius_m = radius_m_;
    settings.haptics.coupling.damping_Ns_per_m = 2.0;
    const auto setup = make_setup(settings);
    EXPECT_TRUE(setup.ok());
    setup_ = canonical_setup(*setup, angle_deg, rotates);
    normal_ = direction_in_plane(motor_rad_ + angle_deg * kDegree);
  }

  // The device point that is this deep in the wall, beside its middle by along_m.
  Vec3 device_m(double depth_m, double along_m = 0.0) const {
    return (radius_m_ - depth_m) * normal_ + along_m * Vec3(-normal_.y(), normal_.x(), 0.0);
  }
  std::vector<TickRecord> touched(const std::vector<Vec3>& path_m) const {
    const auto replayed = replay(*wall_, *setup_, path_m, 1);
    EXPECT_TRUE(replayed.ok());
    return replayed->records;
  }
  const Vec3& normal() const { return normal_; }
  Vec3 motor() const { return direction_in_plane(motor_rad_); }
  double dt_s() const { return setup_->dt_s; }
  double radius_m() const { return radius_m_; }

 private:
  double motor_rad_;
  double radius_m_;
  Result<Scene> wall_;
  std::optional<RunSetup> setup_;
  Vec3 normal_;
};

CanonicalMeasures measures_of(const std::vector<TickRecord>& records, double radius_m) {
  CanonicalMeasures measures(radius_m);
  for (const TickRecord& record : records) measures.on_tick(record);
  return measures;
}

// Pressed: from outside to the depth in 1 s, then held for 2 s; and slid along the wall, as a
// device without a hand.
std::vector<Vec3> pressed_path(const GivenWall& wall, double slide_m) {
  std::vector<Vec3> path_m;
  for (int n = 0; n <= 3000; ++n) {
    const double pressed = std::min(1.0, n * 1e-3);
    path_m.push_back(wall.device_m(pressed * (kOutside_m + kDepth_m) - kOutside_m,
                                   slide_m * std::max(0.0, n * 1e-3 - 1.0)));
  }
  return path_m;
}

class CanonicalAngle : public testing::TestWithParam<int> {};

TEST_P(CanonicalAngle, ADeviceOnAGivenPathFeelsTheTangentOfTheAngle) {
  const double angle_deg = GetParam();
  test::Random random(2300 + static_cast<std::uint64_t>(GetParam()));
  for (int pose = 0; pose < 8; ++pose) {
    const GivenWall wall(random, angle_deg, false);
    const double slide_m = pose % 2 == 0 ? 0.0 : random.uniform(-0.05, 0.05);
    const auto records = wall.touched(pressed_path(wall, slide_m));
    const CanonicalMeasures measures = measures_of(records, wall.radius_m());
    EXPECT_FALSE(measures.is_spoilt());
    ASSERT_TRUE(measures.along_over_into().has_value());
    const double tangent = std::tan(angle_deg * kDegree);
    EXPECT_NEAR(*measures.along_over_into(), tangent, 0.01 * tangent);
    EXPECT_EQ(measures.share_within_30deg(), angle_deg <= 30.0 ? 1.0 : 0.0);
  }
}

TEST_P(CanonicalAngle, TheForceIsThePartOfTheSpringAlongTheMotor) {
  const double angle_deg = GetParam();
  test::Random random(2400 + static_cast<std::uint64_t>(GetParam()));
  const GivenWall wall(random, angle_deg, false);
  const auto records = wall.touched(pressed_path(wall, 0.0));
  const Vec3 spring_N = 1000.0 * kDepth_m * wall.normal();
  const Vec3 expected_N = spring_N.dot(wall.motor()) * wall.motor();
  const TickRecord& last = records.back();  // at rest: the damper has no force
  // The proxy stands off the face by a share of the wall's size, which is at most twice its length.
  const double stand_off_m = SolverScale::kStandOffPerSize * 4.0 * kWallHalfLength_m;
  EXPECT_LT((Vec3(last.force_device_N) - expected_N).norm(), 1000.0 * stand_off_m);
}

INSTANTIATE_TEST_SUITE_P(Angles, CanonicalAngle, testing::Values(15, 30, 45, 60, 75));

TEST(CanonicalWall, NoNumberStandsWhereTheMotorCannotPushIntoTheWall) {
  test::Random random(2500);
  for (int pose = 0; pose < 20; ++pose) {
    const GivenWall wall(random, 90.0, false);
    const CanonicalMeasures measures =
        measures_of(wall.touched(pressed_path(wall, 0.0)), wall.radius_m());
    EXPECT_FALSE(measures.along_over_into().has_value());
    EXPECT_EQ(measures.share_within_30deg(), 0.0);
  }
  // But where it barely can.
  const GivenWall wall(random, 89.99, false);
  const CanonicalMeasures measures =
      measures_of(wall.touched(pressed_path(wall, 0.0)), wall.radius_m());
  ASSERT_TRUE(measures.along_over_into().has_value());
  EXPECT_NEAR(*measures.along_over_into() / std::tan(89.99 * kDegree), 1.0, 1e-6);
}

TEST(CanonicalWall, AWallAcrossTheMotorHasNoForceAlongIt) {
  test::Random random(2510);
  for (int pose = 0; pose < 20; ++pose) {
    const GivenWall wall(random, 0.0, false);
    const CanonicalMeasures measures =
        measures_of(wall.touched(pressed_path(wall, 0.0)), wall.radius_m());
    ASSERT_TRUE(measures.along_over_into().has_value());
    EXPECT_LT(*measures.along_over_into(), 0x1p-47);  // the rounding of N
    EXPECT_EQ(measures.share_within_30deg(), 1.0);
  }
}

TEST(CanonicalWall, WithoutContactNothingIsMeasured) {
  test::Random random(2520);
  const GivenWall wall(random, 30.0, true);
  const CanonicalMeasures measures = measures_of(
      wall.touched(std::vector<Vec3>(100, wall.device_m(-kOutside_m))), wall.radius_m());
  EXPECT_FALSE(measures.is_spoilt());
  EXPECT_FALSE(measures.along_over_into().has_value());
  EXPECT_FALSE(measures.share_within_30deg().has_value());
}

TEST(CanonicalWall, AnAngleOf30DegIsWithinThemWhateverItsRounding) {
  TickRecord record;
  record.contact = 1;
  for (const auto& [angle_rad, share] :
       {std::pair(30.0 * kDegree * (1.0 - 0x1p-50), 1.0), std::pair(30.0 * kDegree, 1.0),
        std::pair(30.0 * kDegree * (1.0 + 0x1p-50), 1.0),
        std::pair(30.0 * kDegree * (1.0 + 0x1p-40), 0.0)}) {
    record.alpha_rad = angle_rad;
    EXPECT_EQ(measures_of({record}, 0.0).share_within_30deg(), share);
  }
}

// The front of the plate is two triangles, and their common edge goes through its middle. While a
// sphere rolls over the edge, its contact normal is a little off.
TEST(CanonicalWall, ASphereThatRollsOverTheEdgeOfTwoTrianglesMeasuresTheWall) {
  test::Random random(2525);
  int off = 0;
  for (const double radius_m : {0.0, 1e-3, 3e-3, 10e-3, 30e-3, 60e-3, 90e-3}) {
    SCOPED_TRACE("radius " + std::to_string(radius_m) + " m");
    const auto rolled = [&](double angle_deg) {
      const GivenWall wall(random, angle_deg, false, radius_m);
      std::vector<Vec3> path_m{wall.device_m(-1e-3)};
      for (int n = -500; n <= 500; ++n) path_m.push_back(wall.device_m(kDepth_m, n * 2e-8));
      return wall.touched(path_m);
    };
    const auto records = rolled(30.0);
    for (const TickRecord& record : records) {
      off += record.contact && std::abs(record.alpha_rad - 30.0 * kDegree) > 0x1p-47;
    }
    EXPECT_EQ(measures_of(records, radius_m).share_within_30deg(), 1.0);
    EXPECT_FALSE(measures_of(rolled(90.0), radius_m).along_over_into().has_value());
    // But the tolerance is no degree.
    EXPECT_EQ(measures_of(rolled(30.01), radius_m).share_within_30deg(), 0.0);
    const auto steep = measures_of(rolled(89.9), radius_m).along_over_into();
    ASSERT_TRUE(steep.has_value());
    EXPECT_NEAR(*steep / std::tan(89.9 * kDegree), 1.0, 1e-2);
  }
  EXPECT_GT(off, 0) << "no sphere touched the edge";
}

// Above 30 deg, A4 turns the wall at 90 deg/s (Figure 3). The device is put into the wall in one
// tick and stands still from the first contact on.
TEST(CanonicalWall, A4BringsTheAngleTo30DegInTheTimeOfFigure3) {
  test::Random random(2530);
  for (const double angle_deg : {45.0, 60.0, 75.0}) {
    for (int pose = 0; pose < 8; ++pose) {
      SCOPED_TRACE(std::to_string(angle_deg) + " deg, pose " + std::to_string(pose));
      const GivenWall wall(random, angle_deg, true);
      std::vector<Vec3> path_m(10, wall.device_m(-1e-3));
      path_m.resize(1500, wall.device_m(kDepth_m));
      const auto records = wall.touched(path_m);
      EXPECT_FALSE(records[9].contact);
      std::size_t passed = 10;
      while (passed < records.size() && records[passed].alpha_rad > 30.0 * kDegree) {
        ASSERT_TRUE(records[passed].contact);
        const double turned_deg = 90.0 * static_cast<double>(passed - 10) * wall.dt_s();
        EXPECT_NEAR(records[passed].alpha_rad, (angle_deg - turned_deg) * kDegree, 1e-12);
        ++passed;
      }
      // 75 deg is exactly 500 ticks away, so that rounding decides between two of them.
      const double expected_ticks = (angle_deg - 30.0) / 90.0 / wall.dt_s();
      const auto ticks = static_cast<double>(passed - 10);
      EXPECT_GT(ticks, expected_ticks - 1e-9);
      EXPECT_LT(ticks, expected_ticks + 1.0 + 1e-9);
    }
  }
}

// While the wall turns, f.N and the part of f along the wall follow from the angle of each tick.
TEST(CanonicalWall, WithA4TheRatioIsThatOfTheAnglesOnTheWay) {
  test::Random random(2540);
  for (const double angle_deg : {-75.0, -30.0, 15.0, 45.0, 60.0, 75.0}) {
    SCOPED_TRACE(std::to_string(angle_deg) + " deg");
    const GivenWall wall(random, angle_deg, true);
    std::vector<Vec3> path_m(10, wall.device_m(-1e-3));
    path_m.resize(1000, wall.device_m(kDepth_m));
    const auto records = wall.touched(path_m);
    double along = 0.0, into = 0.0, within = 0.0;
    double angle_rad = std::abs(angle_deg) * kDegree;
    double depth_m = kDepth_m;
    for (std::size_t n = 10; n < path_m.size(); ++n) {
      along += depth_m * std::cos(angle_rad) * std::sin(angle_rad);
      into += depth_m * std::cos(angle_rad) * std::cos(angle_rad);
      if (angle_rad <= 30.0 * kDegree) within += 1.0;
      // Figure 3 in small steps. The proxy slides to the foot of the device point on the turned
      // wall.
      const double before_rad = angle_rad;
      constexpr int kSteps = 100;
      for (int step = 0; step < kSteps; ++step) {
        const double speed_deg = std::min(90.0, 5.0 + 85.0 * angle_rad / (30.0 * kDegree));
        angle_rad = std::max(0.0, angle_rad - speed_deg * kDegree * wall.dt_s() / kSteps);
      }
      depth_m *= std::cos(before_rad - angle_rad);
    }
    const CanonicalMeasures measures = measures_of(records, wall.radius_m());
    ASSERT_TRUE(measures.along_over_into().has_value());
    EXPECT_NEAR(*measures.along_over_into() / (along / into), 1.0, 1e-3);
    EXPECT_NEAR(*measures.share_within_30deg(), within / 990.0, 1.5 / 990.0);
  }
}

TEST(CanonicalWall, AProxyBeyondAnEndOfTheWallSpoilsATrial) {
  test::Random random(2550);
  for (const double end : {-1.0, 1.0}) {
    const GivenWall wall(random, 30.0, false);
    const double last_m = kWallHalfLength_m - 1e-3;
    EXPECT_FALSE(measures_of(wall.touched({wall.device_m(-1e-3, end * last_m),
                                           wall.device_m(1e-3, end * last_m)}),
                             wall.radius_m())
                     .is_spoilt());
    EXPECT_TRUE(measures_of(wall.touched({wall.device_m(-1e-3, end * last_m),
                                          wall.device_m(-1e-3, end * (last_m + 2e-3))}),
                            wall.radius_m())
                    .is_spoilt());
  }
}

}  // namespace
}  // namespace palpate
