#include "haptics/a4/actuation.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kPi = std::numbers::pi;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// The error of a projected unit vector: each of its three products and sums is rounded, and the
// basis is orthonormal to two roundings.
constexpr double kProjectionRoundoff = 16 * kEpsilon;

// The one-line message of a refused model.
std::string refusal(const Result<ActuationModel>& result) {
  if (!result) {
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
    return result.error().to_string();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

void expect_refused(const Result<ActuationModel>& result, const std::string& element,
                    const std::string& reason) {
  const std::string said = refusal(result);
  EXPECT_TRUE(said.starts_with(element)) << said;
  EXPECT_NE(said.find(reason), std::string::npos) << said;
}

ActuationModel accepted(const Result<ActuationModel>& result) {
  if (result) return *result;
  ADD_FAILURE() << result.error().to_string();
  return *ActuationModel::from_counts(3, 3);
}

// A direction within the sensed axes, of any length.
Vec3 sensed_direction(Random& random, int sensors) {
  Vec3 axis = random.unit_vector();
  if (sensors == 2) axis.z() = 0.0;
  return axis.normalized() * std::pow(10.0, random.uniform(-6.0, 6.0));
}

struct SkewedModel {
  ActuationModel model;
  Eigen::MatrixXd axes;  // one unit column per axis, at least 1 degree off the others' span
};

SkewedModel random_model(Random& random, int sensors, int actuators) {
  for (;;) {
    std::vector<Vec3> axes;
    Eigen::MatrixXd columns(3, actuators);
    for (int i = 0; i < actuators; ++i) {
      axes.push_back(sensed_direction(random, sensors));
      columns.col(i) = axes.back().normalized();
    }
    const double volume = std::sqrt((columns.transpose() * columns).determinant());
    if (volume > std::sin(kPi / 180.0)) {
      return {accepted(ActuationModel::from_axes(sensors, axes)), columns};
    }
  }
}

TEST(ActuationCounts, EveryRowOfTable1HasItsCase) {
  const auto table1_case = [](int sensors, int actuators) {
    return accepted(ActuationModel::from_counts(sensors, actuators)).table1_case();
  };
  EXPECT_EQ(table1_case(2, 0), ActuationCase::kNoActuator);
  EXPECT_EQ(table1_case(3, 0), ActuationCase::kNoActuator);
  EXPECT_EQ(table1_case(2, 1), ActuationCase::kCase1);
  EXPECT_EQ(table1_case(3, 1), ActuationCase::kCase2);
  EXPECT_EQ(table1_case(3, 2), ActuationCase::kCase3);
  EXPECT_EQ(table1_case(2, 2), ActuationCase::kFullyActuated);
  EXPECT_EQ(table1_case(3, 3), ActuationCase::kFullyActuated);
}

TEST(ActuationCounts, ActuateTheFirstAxes) {
  for (int sensors = 2; sensors <= 3; ++sensors) {
    for (int actuators = 0; actuators <= sensors; ++actuators) {
      const ActuationModel model = accepted(ActuationModel::from_counts(sensors, actuators));
      EXPECT_EQ(model.sensors(), sensors);
      EXPECT_EQ(model.actuators(), actuators);
      EXPECT_EQ(model.is_planar(), sensors == 2);
      Vec3 expected(1.0, 2.0, 3.0);
      for (int i = actuators; i < 3; ++i) expected[i] = 0.0;
      EXPECT_EQ(model.actuated_part({1.0, 2.0, 3.0}), expected);
      for (int i = 0; i < actuators; ++i) EXPECT_EQ(model.actuated_axis(i), Vec3(Vec3::Unit(i)));
    }
  }
}

TEST(ActuationCounts, RefusesSensorsThatAreNot2Or3) {
  for (int actuators = -1; actuators <= 2; ++actuators) {
    expect_refused(ActuationModel::from_counts(1, actuators), "sensors", "no axis to rotate about");
  }
  for (const int sensors : {-1, 0, 4, 6}) {
    const std::string reason = "is " + std::to_string(sensors) + "; expected 2 or 3";
    expect_refused(ActuationModel::from_counts(sensors, 1), "sensors", reason);
    expect_refused(ActuationModel::from_axes(sensors, {Vec3::UnitX()}), "sensors", reason);
  }
}

TEST(ActuationCounts, RefusesActuatorsThatAreNotSensed) {
  expect_refused(ActuationModel::from_counts(2, 3), "actuators", "is 3; expected at most 2");
  expect_refused(ActuationModel::from_counts(3, 4), "actuators", "is 4; expected at most 3");
  expect_refused(ActuationModel::from_counts(3, -1), "actuators", "is -1; expected 0 or more");
}

TEST(ActuationAxes, DetermineTheNumberOfActuators) {
  EXPECT_EQ(accepted(ActuationModel::from_axes(3, {})).table1_case(), ActuationCase::kNoActuator);
  EXPECT_EQ(accepted(ActuationModel::from_axes(2, {Vec3(1, 1, 0)})).table1_case(),
            ActuationCase::kCase1);
  EXPECT_EQ(accepted(ActuationModel::from_axes(3, {Vec3(0, 0, -2)})).table1_case(),
            ActuationCase::kCase2);
  EXPECT_EQ(accepted(ActuationModel::from_axes(3, {Vec3(0, 0, 1), Vec3(1, 0, 1)})).table1_case(),
            ActuationCase::kCase3);
  EXPECT_EQ(accepted(ActuationModel::from_axes(2, {Vec3(0, 3, 0), Vec3(1, 1, 0)})).table1_case(),
            ActuationCase::kFullyActuated);
}

TEST(ActuationAxes, MayHaveAnyLengthButZero) {
  for (const double length : {1e-320, 1e-300, 1e-9, 1.0, 1e9, 1e300}) {
    const ActuationModel model =
        accepted(ActuationModel::from_axes(3, {length * Vec3(0, 3, 4), length * Vec3(0, 3, 5)}));
    // Below 1e-308 a double has fewer digits, so that the direction is less exact.
    const double digits = std::max(kEpsilon, std::numeric_limits<double>::denorm_min() / length);
    EXPECT_LE((model.actuated_axis(0) - Vec3(0, 0.6, 0.8)).norm(), 4 * digits);
    EXPECT_LE(std::abs(model.actuated_axis(1).x()), 4 * digits);
  }
}

TEST(ActuationAxes, RefusesAxesWithoutDirection) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Vec3& axis : {Vec3(0, 0, 0), Vec3(nan, 0, 0), Vec3(0, infinity, 0)}) {
    expect_refused(ActuationModel::from_axes(3, {Vec3::UnitX(), axis}), "actuated axis 2 (",
                   "finite vector of non-zero length");
  }
}

TEST(ActuationAxes, RefusesDuplicatesAndOtherDependentAxes) {
  Random random(3101);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = sensed_direction(random, 3);
    const Vec3 b = sensed_direction(random, 3);
    const Vec3 in_plane = random.uniform(-1, 1) * a.normalized() + b.normalized();
    ASSERT_FALSE(ActuationModel::from_axes(3, {a, -2.0 * a}));
    ASSERT_FALSE(ActuationModel::from_axes(3, {a, b, in_plane}));
  }
  expect_refused(ActuationModel::from_axes(3, {Vec3(1, 2, 2), Vec3(1, 2, 2)}),
                 "actuated axis 2 (1 2 2)", "depends linearly on the axes before it");
}

TEST(ActuationAxes, RefusesAxesOutsideTheSensedPlane) {
  for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 0, 1e-9), Vec3(1e9, 1e9, -1e-3)}) {
    expect_refused(ActuationModel::from_axes(2, {axis}), "actuated axis 1 (",
                   "leaves the plane of the sensed axes");
    EXPECT_TRUE(ActuationModel::from_axes(3, {axis}));
  }
}

TEST(ActuationAxes, RefusesMoreAxesThanSensors) {
  const std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3(1, 1, 0)};
  expect_refused(ActuationModel::from_axes(2, axes), "actuated axis 3 (",
                 "expected at most one axis per sensor");
  expect_refused(
      ActuationModel::from_axes(3, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), Vec3(1, 1, 1)}),
      "actuated axis 4 (", "expected at most one axis per sensor");
}

class ActuatedSpan : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(ActuatedSpan, ProjectsOnTheColumnSpaceOfTheAxes) {
  const auto [sensors, actuators] = GetParam();
  Random random(3102);
  for (int i = 0; i < 2000; ++i) {
    const SkewedModel skewed = random_model(random, sensors, actuators);
    const Vec3 v = random.unit_vector();
    // Least squares: an oracle that does not orthonormalise.
    const Eigen::MatrixXd& axes = skewed.axes;
    const Vec3 expected = axes * axes.colPivHouseholderQr().solve(Eigen::VectorXd(v));
    // Axes that are 1 degree apart determine their span with an error 57 times larger than their
    // own.
    ASSERT_LE((skewed.model.actuated_part(v) - expected).norm(), 57 * kProjectionRoundoff);
    ASSERT_LE((skewed.model.actuated_axis(0) - Vec3(axes.col(0))).norm(), kProjectionRoundoff);
  }
}

TEST_P(ActuatedSpan, ProjectionIsOrthogonalAndIdempotent) {
  const auto [sensors, actuators] = GetParam();
  Random random(3103);
  for (int i = 0; i < 2000; ++i) {
    const ActuationModel model = random_model(random, sensors, actuators).model;
    const Vec3 v = random.unit_vector();
    const Vec3 w = random.unit_vector();
    const Vec3 part = model.actuated_part(v);
    ASSERT_LE((model.actuated_part(part) - part).norm(), kProjectionRoundoff);
    ASSERT_LE(std::abs((v - part).dot(model.actuated_part(w))), kProjectionRoundoff);
    ASSERT_LE(part.norm(), 1.0 + kProjectionRoundoff);
    for (int k = 0; k < actuators; ++k) {
      for (int j = 0; j < actuators; ++j) {
        const double expected = j == k ? 1.0 : 0.0;
        ASSERT_LE(std::abs(model.actuated_axis(k).dot(model.actuated_axis(j)) - expected),
                  kProjectionRoundoff);
      }
    }
  }
}

TEST_P(ActuatedSpan, AngleRefersToTheNearestDirectionInTheSpan) {
  const auto [sensors, actuators] = GetParam();
  Random random(3104);
  for (int i = 0; i < 2000; ++i) {
    const ActuationModel model = random_model(random, sensors, actuators).model;
    // Projected twice, because a short first projection is inaccurate.
    Vec3 along = model.actuated_part(random.unit_vector()).normalized();
    along = model.actuated_part(along).normalized();
    Vec3 across = random.unit_vector();
    for (int pass = 0; pass < 2; ++pass) {
      across = (across - model.actuated_part(across)).stableNormalized();
    }
    const double angle = actuators == 3 ? 0.0 : random.uniform(0.0, kPi / 2);
    const Vec3 v = std::cos(angle) * along + std::sin(angle) * across;
    ASSERT_LE(std::abs(model.angle_to_actuated_rad(v) - angle), kProjectionRoundoff);
    ASSERT_LE(std::abs(model.angle_to_actuated_rad(-v) - angle), kProjectionRoundoff);
    const double any = model.angle_to_actuated_rad(random.unit_vector());
    ASSERT_GE(any, 0.0);
    ASSERT_LE(any, kPi / 2);
  }
}

INSTANTIATE_TEST_SUITE_P(Counts, ActuatedSpan,
                         testing::Values(std::pair(2, 1), std::pair(2, 2), std::pair(3, 1),
                                         std::pair(3, 2), std::pair(3, 3)),
                         [](const auto& counts) {
                           return std::to_string(counts.param.first) + "Sensors" +
                                  std::to_string(counts.param.second) + "Actuators";
                         });

TEST(ActuatedAngle, IsARightAngleWithoutActuators) {
  Random random(3105);
  for (int sensors = 2; sensors <= 3; ++sensors) {
    const ActuationModel model = accepted(ActuationModel::from_counts(sensors, 0));
    const Vec3 v = random.unit_vector();
    EXPECT_EQ(model.actuated_part(v), Vec3(Vec3::Zero()));
    EXPECT_EQ(model.angle_to_actuated_rad(v), kPi / 2);
  }
}

TEST(ActuatedAngle, KeepsItsDigitsNearAlignment) {
  const ActuationModel line = accepted(ActuationModel::from_counts(3, 1));
  const ActuationModel plane = accepted(ActuationModel::from_counts(3, 2));
  for (const double angle : {1e-4, 1e-8, 1e-12, 1e-100}) {
    EXPECT_DOUBLE_EQ(line.angle_to_actuated_rad({std::cos(angle), 0, -std::sin(angle)}), angle);
    EXPECT_DOUBLE_EQ(plane.angle_to_actuated_rad({0, std::cos(angle), std::sin(angle)}), angle);
  }
}

}  // namespace
}  // namespace palpate
