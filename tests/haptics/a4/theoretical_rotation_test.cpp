#include "haptics/a4/theoretical_rotation.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/a4/elementary_rotation.h"
#include "haptics/a4/scene_pose.h"
#include "tests/haptics/a4/degrees.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::degrees;
using test::kEpsilon;
using test::radians;
using test::Random;

constexpr double kBandDeg = TheoreticalRotation::kHysteresisDeg;

Vec3 turned(const AxisAngle& turn, const Vec3& v) {
  return Eigen::AngleAxisd(turn.angle_rad, turn.axis_device) * v;
}

// A row of Table 1 with actuated axes in any direction, and a frame for writing normals.
struct Row {
  ActuationModel model;
  Vec3 along;   // in the actuated span: the axis, or any direction in the plane
  Vec3 across;  // unit, orthogonal to the actuated span, in the sensed span
};

Row random_row(Random& random, ActuationCase table1_case) {
  Mat3 frame = random.rotation().toRotationMatrix();
  if (table1_case == ActuationCase::kCase1) {
    frame = Eigen::AngleAxisd(random.uniform(0.0, 2.0 * std::numbers::pi), Vec3::UnitZ())
                .toRotationMatrix();
  }
  const int sensors = table1_case == ActuationCase::kCase1 ? 2 : 3;
  std::vector<Vec3> axes = {frame.col(0)};
  if (table1_case == ActuationCase::kCase3) axes.push_back(frame.col(0) + 0.5 * frame.col(2));
  const auto model = ActuationModel::from_axes(sensors, axes);
  EXPECT_TRUE(model);
  EXPECT_EQ(model->table1_case(), table1_case);
  // The frame is computed from the model's basis, so that the normals have the intended angles.
  const Vec3 along = model->actuated_axis(0);
  Vec3 across = frame.col(1);
  for (int pass = 0; pass < 2; ++pass) {
    across = (across - model->actuated_part(across)).normalized();
  }
  if (table1_case == ActuationCase::kCase3) {
    const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    return {*model, std::cos(turn) * along + std::sin(turn) * model->actuated_axis(1), across};
  }
  return {*model, along, across};
}

Vec3 normal_at(const Row& row, double angle_rad) {
  return std::cos(angle_rad) * row.along + std::sin(angle_rad) * row.across;
}

class Table1 : public testing::TestWithParam<ActuationCase> {};

// Within the hysteresis, the normal may be farther from T than from -T; another test covers that
// case.
TEST_P(Table1, TheFullRotationMovesTheNormalIntoTheActuatedSpan) {
  Random random(3401);
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const Row row = random_row(random, GetParam());
    const Vec3 normal = normal_at(row, random.uniform(-std::numbers::pi, std::numbers::pi));
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    const Vec3 aligned = turned(rotation.update(normal), normal);
    worst = std::max(worst, (aligned - row.model.actuated_part(aligned)).norm());
  }
  EXPECT_LE(worst, 1e-15);
}

TEST_P(Table1, TheAngleRefersToTheNearestActuatedDirection) {
  Random random(3402);
  for (int i = 0; i < 10000; ++i) {
    const Row row = random_row(random, GetParam());
    const double limit_deg = 90.0 - kBandDeg;
    const double angle_rad = radians(random.uniform(-limit_deg, limit_deg));
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    const AxisAngle turn = rotation.update(sign * normal_at(row, angle_rad));
    ASSERT_LE(std::abs(turn.angle_rad - std::abs(angle_rad)), 16 * kEpsilon);
    ASSERT_LE(std::abs(turn.axis_device.norm() - 1.0), 4 * kEpsilon);
    // The axis turns the normal towards the actuated direction by the smaller angle.
    const Vec3 expected_axis =
        angle_rad > 0 ? Vec3(row.across.cross(row.along)) : Vec3(row.along.cross(row.across));
    ASSERT_LE((turn.axis_device - expected_axis).norm() * std::abs(angle_rad), 32 * kEpsilon);
  }
}

TEST_P(Table1, TheAngleKeepsItsDigitsNearAlignment) {
  const auto [sensors, actuators] = GetParam() == ActuationCase::kCase1   ? std::pair(2, 1)
                                    : GetParam() == ActuationCase::kCase2 ? std::pair(3, 1)
                                                                          : std::pair(3, 2);
  const ActuationModel model = *ActuationModel::from_counts(sensors, actuators);
  for (const double angle_rad : {1e-3, 1e-8, 1e-15, 1e-100}) {
    TheoreticalRotation rotation(model, Table1Form::kCorrected);
    Vec3 normal(std::cos(angle_rad), 0.0, 0.0);
    normal[actuators] = std::sin(angle_rad);
    EXPECT_DOUBLE_EQ(rotation.update(normal).angle_rad, angle_rad);
  }
}

TEST_P(Table1, AnAlignedNormalNeedsNoRotation) {
  Random random(3403);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    for (const double sign : {1.0, -1.0, 1.0}) {  // without a reset between them
      const Vec3 exact = sign * row.model.actuated_axis(0);
      ASSERT_LE(rotation.update(exact).angle_rad, 2 * kEpsilon);
      ASSERT_LE(rotation.update(sign * row.along).angle_rad, 4 * kEpsilon);
    }
  }
}

TEST_P(Table1, GivesFiniteNumbersForEveryNormal) {
  Random random(3404);
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (int i = 0; i < 5000; ++i) {
    const Row row = random_row(random, GetParam());
    std::vector<Vec3> normals = {row.along, row.across, row.model.actuated_axis(0), Vec3::Zero()};
    for (int axis = 0; axis < 3; ++axis) normals.push_back(Vec3::Unit(axis));
    normals.push_back(normal_at(row, random.uniform(-std::numbers::pi, std::numbers::pi)));
    normals.push_back(row.along + tiny * row.across);
    normals.push_back(row.across + 1e-17 * row.along);
    for (const Table1Form form : {Table1Form::kCorrected, Table1Form::kAsPrinted}) {
      TheoreticalRotation rotation(row.model, form);
      for (int k = 0; k < 20; ++k) {
        const double sign = random.index(2) == 0 ? 1.0 : -1.0;
        const AxisAngle turn = rotation.update(sign * normals[random.index(normals.size())]);
        ASSERT_TRUE(turn.axis_device.allFinite());
        ASSERT_LE(std::abs(turn.axis_device.norm() - 1.0), 4 * kEpsilon);
        ASSERT_GE(turn.angle_rad, 0.0);
        ASSERT_LE(turn.angle_rad, form == Table1Form::kAsPrinted
                                      ? std::numbers::pi
                                      : radians(90.0 + kBandDeg) + kEpsilon);
        if (random.index(5) == 0) rotation.reset();
      }
    }
  }
}

TEST_P(Table1, GivesNoRotationWithoutANormal) {
  Random random(3416);
  for (const Table1Form form : {Table1Form::kCorrected, Table1Form::kAsPrinted}) {
    TheoreticalRotation rotation(random_row(random, GetParam()).model, form);
    EXPECT_EQ(rotation.update(Vec3::Zero()).angle_rad, 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, Table1,
                         testing::Values(ActuationCase::kCase1, ActuationCase::kCase2,
                                         ActuationCase::kCase3),
                         [](const auto& row) {
                           return "Case" + std::to_string(static_cast<int>(row.param));
                         });

TEST(TheoreticalRotation, Case1TurnsBothHalfPlanesByTheSmallerAngle) {
  const ActuationModel model = *ActuationModel::from_counts(2, 1);
  for (double angle_deg = -91.0; angle_deg <= 91.0; angle_deg += 2.0) {
    TheoreticalRotation rotation(model, Table1Form::kCorrected);
    const double angle_rad = radians(angle_deg);
    const AxisAngle turn = rotation.update({std::cos(angle_rad), std::sin(angle_rad), 0.0});
    EXPECT_EQ(turn.axis_device, Vec3(0.0, 0.0, angle_deg > 0 ? -1.0 : 1.0));
    EXPECT_NEAR(turn.angle_rad, std::abs(angle_rad), 2 * kEpsilon);
  }
}

TEST(TheoreticalRotation, IsZeroIfNoOrEverySensedAxisIsActuated) {
  Random random(3405);
  for (const auto& [sensors, actuators] :
       {std::pair(2, 0), std::pair(3, 0), std::pair(2, 2), std::pair(3, 3)}) {
    for (const Table1Form form : {Table1Form::kCorrected, Table1Form::kAsPrinted}) {
      TheoreticalRotation rotation(*ActuationModel::from_counts(sensors, actuators), form);
      EXPECT_EQ(rotation.update(random.unit_vector()).angle_rad, 0.0);
    }
  }
}

// The direction with which the normal at angle_rad is aligned: +1 for row.along, -1 for its
// opposite.
int sign_chosen(TheoreticalRotation& rotation, const Row& row, double angle_rad) {
  const Vec3 normal = normal_at(row, angle_rad);
  const double cosine = turned(rotation.update(normal), normal).dot(row.along);
  EXPECT_LE(std::abs(std::abs(cosine) - 1.0), 16 * kEpsilon) << degrees(angle_rad);
  return cosine > 0.0 ? 1 : -1;
}

class OneActuator : public testing::TestWithParam<ActuationCase> {};

TEST_P(OneActuator, SignChangesOnlyBeyondTheHysteresis) {
  Random random(3406);
  for (int i = 0; i < 100; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    const double side = random.index(2) == 0 ? 1.0 : -1.0;
    constexpr int kSweep = 1000;  // hundredths of a degree, from 85 to 95; halves avoid the limit
    for (int k = 0; k < kSweep; ++k) {
      const double angle_deg = 85.005 + 0.01 * k;
      ASSERT_EQ(sign_chosen(rotation, row, side * radians(angle_deg)),
                angle_deg > 90.0 + kBandDeg ? -1 : 1);
    }
    for (int k = kSweep; k-- > 0;) {
      const double angle_deg = 85.005 + 0.01 * k;
      ASSERT_EQ(sign_chosen(rotation, row, side * radians(angle_deg)),
                angle_deg < 90.0 - kBandDeg ? 1 : -1);
    }
  }
}

TEST_P(OneActuator, SignNeverChangesWithinTheHysteresis) {
  Random random(3407);
  for (int i = 0; i < 100; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    const int sign = random.index(2) == 0 ? 1 : -1;
    ASSERT_EQ(sign_chosen(rotation, row, sign > 0 ? 0.0 : std::numbers::pi), sign);
    for (int k = 0; k < 1000; ++k) {
      const double off_deg = random.uniform(-0.999 * kBandDeg, 0.999 * kBandDeg);
      ASSERT_EQ(sign_chosen(rotation, row, radians(90.0 + off_deg)), sign);
    }
  }
}

TEST_P(OneActuator, SignChangesAtMostOncePerExcursion) {
  Random random(3408);
  for (int i = 0; i < 20; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    double angle_deg = 90.0;
    double travelled_deg = 0.0;
    int flips = 0;
    int last = sign_chosen(rotation, row, radians(angle_deg));
    for (int k = 0; k < 20000; ++k) {
      // The walk is drawn back to 90 degrees; otherwise it would drift away, and the sign would not
      // change again.
      const double step_deg = 0.2 * random.normal() - 0.002 * (angle_deg - 90.0);
      angle_deg += step_deg;
      travelled_deg += std::abs(step_deg);
      const int sign = sign_chosen(rotation, row, radians(angle_deg));
      if (sign == last) continue;
      ++flips;
      last = sign;
      // The sign changes only after a path from one side of the band to the other; 2 degrees are
      // required.
      ASSERT_GE(travelled_deg, flips == 1 ? kBandDeg : 2.0 * kBandDeg);
      travelled_deg = 0.0;
    }
    EXPECT_GT(flips, 5);
  }
}

TEST_P(OneActuator, ANewContactChoosesTheSignWithoutMemory) {
  Random random(3409);
  for (int i = 0; i < 100; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    for (const double side : {1.0, -1.0}) {
      for (const double off_deg : {-80.0, -2.1, -1.9, 0.0, 1.9, 2.1, 80.0}) {
        ASSERT_EQ(sign_chosen(rotation, row, std::numbers::pi), -1);  // another contact before
        rotation.reset();
        ASSERT_EQ(sign_chosen(rotation, row, side * radians(90.0 + off_deg)),
                  off_deg > kBandDeg ? -1 : 1);
      }
    }
  }
}

TEST_P(OneActuator, AContactWithoutNormalKeepsTheMemory) {
  Random random(3410);
  const Row row = random_row(random, GetParam());
  TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
  ASSERT_EQ(sign_chosen(rotation, row, std::numbers::pi), -1);
  EXPECT_EQ(rotation.update(Vec3::Zero()).angle_rad, 0.0);
  EXPECT_EQ(sign_chosen(rotation, row, radians(91.0)), -1);
}

INSTANTIATE_TEST_SUITE_P(Rows, OneActuator,
                         testing::Values(ActuationCase::kCase1, ActuationCase::kCase2),
                         [](const auto& row) {
                           return "Case" + std::to_string(static_cast<int>(row.param));
                         });

// kForward: one actuator, normals at angles from -180 to 180 deg about A3 or any other axis.
class Forward : public testing::TestWithParam<ActuationCase> {};

TheoreticalRotation forward_rotation(const ActuationModel& model) {
  return {model, Table1Form::kCorrected, Alignment::kForward};
}

TEST_P(Forward, TurnsEveryNormalToThePositiveEndByTheSmallerAngle) {
  Random random(3420);
  for (int i = 0; i < 100000; ++i) {
    const Row row = random_row(random, GetParam());
    const double angle_rad = radians(random.uniform(-180.0 + kBandDeg, 180.0 - kBandDeg));
    TheoreticalRotation rotation = forward_rotation(row.model);
    const Vec3 normal = normal_at(row, angle_rad);
    const AxisAngle turn = rotation.update(normal);
    ASSERT_NEAR(turn.angle_rad, std::abs(angle_rad), 16 * kEpsilon);
    ASSERT_LE((turned(turn, normal) - row.along).norm(), 16 * kEpsilon);
  }
}

// The signed turn of a normal at this angle, deg: positive from `along` to `across`.
double signed_turn_deg(TheoreticalRotation& rotation, const Row& row, double angle_deg) {
  const AxisAngle turn = rotation.update(normal_at(row, radians(angle_deg)));
  return degrees(turn.angle_rad) *
         (turn.axis_device.dot(row.along.cross(row.across)) > 0.0 ? 1.0 : -1.0);
}

TEST_P(Forward, UndoesAnAngleOfEitherSignTheWayBack) {
  Random random(3421);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation = forward_rotation(row.model);
    ASSERT_NEAR(signed_turn_deg(rotation, row, 144.0), -144.0, 1e-12);
    rotation.reset();
    ASSERT_NEAR(signed_turn_deg(rotation, row, -144.0), 144.0, 1e-12);
  }
}

// Beyond 180 deg the turn goes on in its direction, up to the hysteresis.
TEST_P(Forward, KeepsItsDirectionWithinTheHysteresis) {
  Random random(3422);
  for (int i = 0; i < 100; ++i) {
    const Row row = random_row(random, GetParam());
    for (const double side : {1.0, -1.0}) {
      TheoreticalRotation rotation = forward_rotation(row.model);
      double last = signed_turn_deg(rotation, row, side * 170.0);
      for (int k = 0; k < 2000; ++k) {  // hundredths of a degree; halves avoid the limit
        const double angle_deg = 170.005 + 0.01 * k;
        const double turn = signed_turn_deg(rotation, row, side * angle_deg);
        const bool is_kept = angle_deg < 180.0 + kBandDeg;
        ASSERT_NEAR(turn, side * (is_kept ? -angle_deg : 360.0 - angle_deg), 1e-11) << angle_deg;
        last = turn;
      }
      ASSERT_GT(side * last, 0.0);
      // Back again, the new direction is kept as far.
      for (int k = 2000; k-- > 0;) {
        const double angle_deg = 170.005 + 0.01 * k;
        const double turn = signed_turn_deg(rotation, row, side * angle_deg);
        const bool is_kept = angle_deg > 180.0 - kBandDeg;
        ASSERT_NEAR(turn, side * (is_kept ? 360.0 - angle_deg : -angle_deg), 1e-11) << angle_deg;
      }
    }
  }
}

// A hand that trembles about the back of the motor's line turns in one direction: any new contact
// there begins with the same one.
TEST_P(Forward, HasOneDirectionNearTheBack) {
  Random random(3423);
  for (int i = 0; i < 200; ++i) {
    const Row row = random_row(random, GetParam());
    TheoreticalRotation rotation = forward_rotation(row.model);
    double first = 0.0;
    for (int k = 0; k < 500; ++k) {
      if (random.index(3) == 0) rotation.reset();
      const double off_deg = random.uniform(-1.0, 1.0);
      const double turn = signed_turn_deg(rotation, row, 180.0 + off_deg);
      if (k == 0) first = turn;
      ASSERT_GT(turn * first, 0.0) << k << ", " << off_deg;
      ASSERT_NEAR(std::abs(turn), 180.0, 1.0 + 1e-11);
      rotation.update(-row.model.actuated_axis(0));  // exactly at the back
    }
  }
}

TEST_P(Forward, ExactlyAtTheBackTurnsByHalfATurn) {
  Random random(3424);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, GetParam());
    const Vec3& a1 = row.model.actuated_axis(0);
    TheoreticalRotation rotation = forward_rotation(row.model);
    const AxisAngle turn = rotation.update(-a1);
    ASSERT_NEAR(turn.angle_rad, std::numbers::pi, 4 * kEpsilon);
    ASSERT_NEAR(turn.axis_device.norm(), 1.0, 4 * kEpsilon);
    ASSERT_NEAR(turn.axis_device.dot(a1), 0.0, 8 * kEpsilon / std::sin(radians(kBandDeg)));
    ASSERT_LE(rotation.update(a1).angle_rad, 4 * kEpsilon);
  }
}

TEST_P(Forward, GivesFiniteNumbersForEveryNormal) {
  Random random(3425);
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (int i = 0; i < 5000; ++i) {
    const Row row = random_row(random, GetParam());
    const std::vector<Vec3> normals = {row.along,
                                       row.across,
                                       row.model.actuated_axis(0),
                                       Vec3::Zero(),
                                       row.along + tiny * row.across,
                                       row.along + 1e-17 * row.across,
                                       normal_at(row, random.uniform(-4.0, 4.0))};
    TheoreticalRotation rotation = forward_rotation(row.model);
    for (int k = 0; k < 20; ++k) {
      const double sign = random.index(2) == 0 ? 1.0 : -1.0;
      const AxisAngle turn = rotation.update(sign * normals[random.index(normals.size())]);
      ASSERT_LE(std::abs(turn.axis_device.norm() - 1.0), 4 * kEpsilon);
      ASSERT_GE(turn.angle_rad, 0.0);
      ASSERT_LE(turn.angle_rad, radians(180.0 + kBandDeg) + 4 * kEpsilon);
      if (random.index(5) == 0) rotation.reset();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, Forward,
                         testing::Values(ActuationCase::kCase1, ActuationCase::kCase2),
                         [](const auto& row) {
                           return "Case" + std::to_string(static_cast<int>(row.param));
                         });

// The scene turns about A3 by Figure 3 until a normal at 144 deg is aligned, which takes
// (144 - 30) / 90 s + 6/17 ln 18 s.
TEST(ForwardTurn, Undoes144DegInTheTimeOfFigure3) {
  const double expected_s = (144.0 - 30.0) / 90.0 + 6.0 / 17.0 * std::log(18.0);
  EXPECT_NEAR(expected_s, 2.286798, 5e-7);
  EXPECT_NEAR(alignment_time_s(RotationProfile{}, radians(144.0)), expected_s, 1e-14);
  const ActuationModel model = *ActuationModel::from_counts(2, 1);
  for (const double side : {1.0, -1.0}) {
    for (const double rate_Hz : {1000.0, 60.0}) {
      TheoreticalRotation rotation = forward_rotation(model);
      const double start_rad = side * radians(144.0);
      const Vec3 normal_scene(std::cos(start_rad), std::sin(start_rad), 0.0);
      ScenePose T_device_scene;
      double turned_rad = 0.0;
      const int whole_ticks = static_cast<int>(expected_s * rate_Hz);
      for (int tick = 1; tick <= whole_ticks + 1; ++tick) {
        const AxisAngle turn = rotation.update(T_device_scene.direction(normal_scene));
        const double step_rad = elementary_rotation_rad(RotationProfile{}, StepRule::kExact,
                                                        turn.angle_rad, 1.0 / rate_Hz);
        ASSERT_EQ(turn.axis_device.z() < 0.0, side > 0.0);
        T_device_scene =
            turned_about(T_device_scene, Vec3::Zero(), Vec3::Zero(), {turn.axis_device, step_rad});
        turned_rad += step_rad;
        // What remains at this time, by the closed form of Figure 3.
        const double left_s = expected_s - tick / rate_Hz;
        const double below_s = 6.0 / 17.0 * std::log(18.0);
        const double left_deg = left_s <= 0.0      ? 0.0
                                : left_s > below_s ? 30.0 + 90.0 * (left_s - below_s)
                                                   : 30.0 / 17.0 * std::expm1(17.0 / 6.0 * left_s);
        const Vec3 n = T_device_scene.direction(normal_scene);
        ASSERT_NEAR(std::atan2(n.y(), n.x()), side * radians(left_deg), 1e-12) << tick;
      }
      EXPECT_NEAR(turned_rad, radians(144.0), 1e-12);
    }
  }
}

// The direction with which a normal is aligned, computed from the rotation.
Vec3 target(TheoreticalRotation& rotation, const Vec3& normal) {
  return turned(rotation.update(normal), normal);
}

TEST(TwoActuators, ANormalOffThePlaneKeepsTheLastDirection) {
  Random random(3411);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, ActuationCase::kCase3);
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    ASSERT_LE((target(rotation, normal_at(row, radians(80.0))) - row.along).norm(), 16 * kEpsilon);
    ASSERT_LE((target(rotation, sign * row.across) - row.along).norm(), 16 * kEpsilon);
    ASSERT_NEAR(rotation.update(sign * row.across).angle_rad, std::numbers::pi / 2, 16 * kEpsilon);
    // Circles around the pole, within the hysteresis.
    const Vec3 aside = row.across.cross(row.along);
    for (int k = 0; k < 36; ++k) {
      const double turn = 2.0 * std::numbers::pi * k / 36;
      const Vec3 level = std::cos(turn) * row.along + std::sin(turn) * aside;
      const double tilt_rad = radians(random.uniform(0.0, 0.99 * kBandDeg));
      const Vec3 normal = std::cos(tilt_rad) * row.across + std::sin(tilt_rad) * level;
      ASSERT_LE((target(rotation, normal) - row.along).norm(), 16 * kEpsilon);
    }
    // Beyond the hysteresis, the direction follows.
    const double beyond_rad = radians(1.01 * kBandDeg);
    const Vec3 normal = std::cos(beyond_rad) * row.across + std::sin(beyond_rad) * aside;
    ASSERT_LE((target(rotation, normal) - aside).norm(), 100 * kEpsilon);
    ASSERT_LE((target(rotation, row.across) - aside).norm(), 100 * kEpsilon);
  }
}

TEST(TwoActuators, ANewContactOffThePlaneAlignsWithTheFirstAxis) {
  Random random(3412);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, ActuationCase::kCase3);
    TheoreticalRotation rotation(row.model, Table1Form::kCorrected);
    for (const Vec3& normal : {row.across, Vec3(-row.across), normal_at(row, radians(88.1))}) {
      ASSERT_LE((target(rotation, normal) - row.model.actuated_axis(0)).norm(), 16 * kEpsilon);
      target(rotation, row.along);
      rotation.reset();
    }
  }
}

// The faults of Table 1 as printed, in numbers.

TEST(PrintedForm, Case1AgreesInOneHalfPlaneOnly) {
  const ActuationModel model = *ActuationModel::from_counts(2, 1);
  TheoreticalRotation printed(model, Table1Form::kAsPrinted);
  for (double angle_deg = 1.0; angle_deg < 90.0; angle_deg += 4.0) {
    const Vec3 above(std::cos(radians(angle_deg)), std::sin(radians(angle_deg)), 0.0);
    const Vec3 below(above.x(), -above.y(), 0.0);
    EXPECT_LE((turned(printed.update(above), above) - Vec3::UnitX()).norm(), 1e-14);
    const Vec3 ends = turned(printed.update(below), below);
    EXPECT_NEAR(degrees(std::atan2(ends.y(), ends.x())), -2.0 * angle_deg, 1e-12);
  }
}

TEST(PrintedForm, Case2AlwaysTurnsToThePositiveAxis) {
  Random random(3413);
  for (int i = 0; i < 1000; ++i) {
    const Row row = random_row(random, ActuationCase::kCase2);
    TheoreticalRotation printed(row.model, Table1Form::kAsPrinted);
    const double angle_deg = random.uniform(1.0, 179.0);
    const Vec3 normal = normal_at(row, radians(angle_deg));
    EXPECT_NEAR(degrees(printed.update(normal).angle_rad), angle_deg, 1e-11);
    EXPECT_LE((target(printed, normal) - row.along).norm(), 1e-13);
  }
}

TEST(PrintedForm, Case3AngleIsUpToASquareRootOf2TooLarge) {
  Random random(3414);
  for (int i = 0; i < 100; ++i) {
    const Row row = random_row(random, ActuationCase::kCase3);
    TheoreticalRotation printed(row.model, Table1Form::kAsPrinted);
    for (const auto& [angle_deg, ratio] :
         {std::pair(0.1, 1.414), std::pair(45.0, 1.333), std::pair(89.999, 1.0)}) {
      const double printed_rad = printed.update(normal_at(row, radians(angle_deg))).angle_rad;
      EXPECT_NEAR(printed_rad / radians(angle_deg), ratio, 0.0005);
    }
  }
}

TEST(PrintedForm, Case3OvershootsIfItsWholeAngleIsTurned) {
  Random random(3415);
  const Row row = random_row(random, ActuationCase::kCase3);
  TheoreticalRotation printed(row.model, Table1Form::kAsPrinted);
  Vec3 normal = normal_at(row, radians(5.0));
  double sign = -1.0;
  for (const double expected_deg : {2.07, 0.86, 0.35}) {
    normal = turned(printed.update(normal), normal);
    EXPECT_NEAR(degrees(std::asin(normal.dot(row.across))), sign * expected_deg, 0.005);
    sign = -sign;
  }
}

struct TimeAndTurn {
  double time_s;
  double turned_deg;
};

// A4's actions 5 and 6 at 1 kHz: the normal starts at -10 deg and turns until it is at 1 deg.
TimeAndTurn align_from_minus_10_deg(Table1Form form) {
  constexpr double kTick_s = 1e-3;
  const ActuationModel model = *ActuationModel::from_counts(2, 1);
  TheoreticalRotation rotation(model, form);
  const Vec3 normal_scene(std::cos(radians(-10.0)), std::sin(radians(-10.0)), 0.0);
  ScenePose pose;
  TimeAndTurn alignment{0.0, 0.0};
  while (alignment.time_s < 10.0) {
    const Vec3 normal = pose.direction(normal_scene);
    if (model.angle_to_actuated_rad(normal) <= radians(1.0) && normal.x() > 0.0) break;
    AxisAngle turn = rotation.update(normal);
    turn.angle_rad =
        elementary_rotation_rad(RotationProfile{}, StepRule::kExact, turn.angle_rad, kTick_s);
    pose = turned_about(pose, Vec3::Zero(), turn);
    alignment.turned_deg += degrees(turn.angle_rad);
    alignment.time_s += kTick_s;
  }
  return alignment;
}

TEST(PrintedForm, Case1FromMinus10DegTakesTheLongWay) {
  const TimeAndTurn printed = align_from_minus_10_deg(Table1Form::kAsPrinted);
  EXPECT_NEAR(printed.time_s, 4.55, 0.005);
  EXPECT_NEAR(printed.turned_deg, 349.0, 0.1);
  const TimeAndTurn corrected = align_from_minus_10_deg(Table1Form::kCorrected);
  EXPECT_NEAR(corrected.time_s, 0.511119, 0.001);  // to the tick
  EXPECT_NEAR(corrected.turned_deg, 9.0, 0.1);
}

}  // namespace
}  // namespace palpate
