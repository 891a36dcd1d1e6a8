// The kinematics of the five-bar linkage, compared with the definition of its links, with
// differences, and with singular values.

#include "engine/devices/five_bar.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kPi = std::numbers::pi;
// The accuracy that the driver states for the kinematics, over all poses that get a force.
constexpr double kStated = 1e-12;

FiveBarLinks some_links(Random& random) {
  return {random.uniform(0.01, 0.05), random.uniform(0.04, 0.08), random.uniform(0.06, 0.12)};
}

// A pose with some force: the tip is in front of the motors, and the condition is below the limit.
struct Pose {
  FiveBar bar{FiveBarLinks{}};
  Vec2 tip_m;
  Vec2 joints_rad;
  Mat2 jacobian;
};

Pose some_pose(Random& random) {
  for (;;) {
    Pose pose;
    if (random.index(2) == 0) pose.bar = FiveBar(some_links(random));
    pose.tip_m = {random.uniform(-0.1, 0.12), random.uniform(0.01, 0.2)};
    const auto joints = pose.bar.inverse(pose.tip_m);
    if (!joints) continue;
    pose.joints_rad = *joints;
    const auto jacobian = pose.bar.jacobian(*joints);
    if (!jacobian || condition_number(*jacobian) > kNoForceCondition) continue;
    pose.jacobian = *jacobian;
    return pose;
  }
}

TEST(FiveBar, PutsTheTipWhereTheMakersExampleHasItsRestPose) {
  // Elbows at (-50, 0) and (70, 0) mm: half of 120 mm is 60 mm, and 70^2 - 60^2 = 1300.
  const auto tip = FiveBar(FiveBarLinks{}).forward({kPi, 0.0});
  ASSERT_TRUE(tip);
  EXPECT_NEAR(tip->x(), 0.010, kStated);
  EXPECT_NEAR(tip->y(), std::sqrt(1300.0) * 1e-3, kStated);
}

TEST(FiveBar, KeepsTheLengthsOfItsLinksAndTheLargerRoot) {
  Random random(1);
  for (int n = 0; n < 2000; ++n) {
    const FiveBar bar(some_links(random));
    const FiveBarLinks& links = bar.links();
    const Vec2 joints(random.uniform(-kPi, kPi), random.uniform(-kPi, kPi));
    const Vec2 first = links.proximal_m * Vec2(std::cos(joints[0]), std::sin(joints[0]));
    const Vec2 second =
        Vec2(links.base_m, 0.0) + links.proximal_m * Vec2(std::cos(joints[1]), std::sin(joints[1]));
    const auto tip = bar.forward(joints);
    ASSERT_EQ(tip.has_value(), (second - first).norm() <= 2.0 * links.distal_m);
    // A point nearly on the line of both elbows depends on its square root.
    if (!tip || (second - first).norm() > 1.99 * links.distal_m) continue;
    EXPECT_NEAR((*tip - first).norm(), links.distal_m, kStated);
    EXPECT_NEAR((*tip - second).norm(), links.distal_m, kStated);
    // The other point at these distances is the mirror image at the line through the elbows.
    const Vec2 other = first + second - *tip;
    if (second.x() > first.x()) {
      EXPECT_GE(tip->y(), other.y());
    }
  }
}

TEST(FiveBar, ForwardIsTheInverseOfInverse) {
  Random random(2);
  for (int n = 0; n < 20'000; ++n) {
    const Pose pose = some_pose(random);
    const auto tip = pose.bar.forward(pose.joints_rad);
    ASSERT_TRUE(tip);
    ASSERT_LE((*tip - pose.tip_m).norm(), kStated) << pose.tip_m.transpose();
  }
}

TEST(FiveBar, InverseHasItsElbowsOutwards) {
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const Pose pose = some_pose(random);
    const Vec2& p = pose.tip_m;
    EXPECT_GE(pose.joints_rad[0], std::atan2(p.y(), p.x()));
    EXPECT_LE(pose.joints_rad[1], std::atan2(p.y(), p.x() - pose.bar.links().base_m));
  }
}

// Central differences of step h have an error of about h^2 |f'''| and a rounding error of about
// epsilon |f| / h. In poses of condition up to 20, f''' is at most the size of the linkage times
// 20^5 (each derivative divides by the sine of the angle between the distal links, of which the
// condition is the reciprocal, twice). Therefore Richardson's extrapolation of two steps is used,
// and the bound is the difference between both.
TEST(FiveBar, JacobianIsTheDerivativeOfForward) {
  Random random(4);
  const auto difference = [](const FiveBar& bar, const Vec2& joints, int k, double h) {
    const Vec2 step = h * Vec2::Unit(k);
    return Vec2((*bar.forward(joints + step) - *bar.forward(joints - step)) / (2.0 * h));
  };
  for (int n = 0; n < 5000; ++n) {
    const Pose pose = some_pose(random);
    for (int k = 0; k < 2; ++k) {
      constexpr double kStep = 1e-4;
      if (!pose.bar.forward(pose.joints_rad + kStep * Vec2::Unit(k)) ||
          !pose.bar.forward(pose.joints_rad - kStep * Vec2::Unit(k))) {
        continue;
      }
      const Vec2 coarse = difference(pose.bar, pose.joints_rad, k, kStep);
      const Vec2 fine = difference(pose.bar, pose.joints_rad, k, 0.5 * kStep);
      const Vec2 best = fine + (fine - coarse) / 3.0;
      const double rounding =
          8.0 * std::numeric_limits<double>::epsilon() / kStep * kNoForceCondition;
      const double bound = (fine - coarse).norm() + rounding;
      ASSERT_LE((pose.jacobian.col(k) - best).norm(), bound) << pose.tip_m.transpose();
      ASSERT_LE(bound, 1e-2 * pose.jacobian.norm()) << "the bound is too wide to show anything";
    }
  }
}

// The velocity of the tip follows from the lengths of the links alone: it is perpendicular, seen
// from each elbow, to the distal link.
TEST(FiveBar, PowerOfTheForceIsThePowerOfTheTorques) {
  Random random(5);
  for (int n = 0; n < 5000; ++n) {
    const Pose pose = some_pose(random);
    const Vec2 speeds(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const Vec2 force_N(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const double l = pose.bar.links().proximal_m;
    const auto [a, b] = std::pair(pose.joints_rad[0], pose.joints_rad[1]);
    const Vec2 first = l * Vec2(std::cos(a), std::sin(a));
    const Vec2 second = Vec2(pose.bar.links().base_m, 0.0) + l * Vec2(std::cos(b), std::sin(b));
    Mat2 links;
    links.row(0) = (pose.tip_m - first).transpose();
    links.row(1) = (pose.tip_m - second).transpose();
    const Vec2 first_velocity = l * speeds[0] * Vec2(-std::sin(a), std::cos(a));
    const Vec2 second_velocity = l * speeds[1] * Vec2(-std::sin(b), std::cos(b));
    const Vec2 velocity =
        links.inverse() * Vec2(links.row(0).dot(first_velocity), links.row(1).dot(second_velocity));
    const Vec2 torques_Nm = pose.jacobian.transpose() * force_N;
    ASSERT_NEAR(force_N.dot(velocity), torques_Nm.dot(speeds), kStated);
  }
}

TEST(FiveBar, HasNoPoseWhereItsLinksCannotMeet) {
  const FiveBar bar{FiveBarLinks{}};
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(bar.inverse({0.01, 0.13}));  // beyond 120 mm
  EXPECT_FALSE(bar.inverse({0.0, 0.01}));   // nearer than 20 mm to the first motor
  EXPECT_FALSE(bar.inverse({kNaN, 0.05}));
  EXPECT_FALSE(bar.forward({kNaN, 0.0}));
  EXPECT_FALSE(bar.forward({std::numeric_limits<double>::infinity(), 0.0}));
  EXPECT_FALSE(bar.jacobian({kNaN, 0.0}));
  // A base of 50 mm: the elbows are 150 mm apart, and two distal links reach 140 mm.
  EXPECT_FALSE(FiveBar(FiveBarLinks{.base_m = 0.05}).forward({kPi, 0.0}));
}

TEST(FiveBar, HasNoJacobianWhereTheDistalLinksAreParallel) {
  // The elbows are 0.5 m apart, exactly two distal links; binary fractions, so without rounding.
  const FiveBar bar({.base_m = 0.25, .proximal_m = 0.125, .distal_m = 0.25});
  const Vec2 joints(kPi, 0.0);
  ASSERT_TRUE(bar.forward(joints));
  const auto jacobian = bar.jacobian(joints);
  EXPECT_TRUE(!jacobian || singularity_factor(condition_number(*jacobian)) == 0.0);
}

TEST(FiveBar, ConditionIsTheRatioOfSingularValues) {
  Random random(6);
  for (int n = 0; n < 2000; ++n) {
    Mat2 m;
    for (int i = 0; i < 4; ++i) m(i / 2, i % 2) = random.uniform(-1.0, 1.0);
    const Vec2 values = Eigen::JacobiSVD<Mat2>(m).singularValues();
    const double ratio = values[0] / values[1];
    // Both the determinant and the judge's smaller value lose the digits that the condition says.
    EXPECT_NEAR(condition_number(m) / ratio, 1.0,
                16.0 * ratio * std::numeric_limits<double>::epsilon());
  }
  EXPECT_EQ(condition_number(Mat2::Identity()), 1.0);
  EXPECT_EQ(condition_number(Mat2::Zero()), std::numeric_limits<double>::infinity());
  EXPECT_EQ(condition_number(Mat2::Ones()), std::numeric_limits<double>::infinity());
}

TEST(FiveBar, ForceFadesTowardsASingularPose) {
  EXPECT_EQ(singularity_factor(1.0), 1.0);
  EXPECT_EQ(singularity_factor(kFullForceCondition), 1.0);
  EXPECT_EQ(singularity_factor(kNoForceCondition), 0.0);
  EXPECT_EQ(singularity_factor(std::numeric_limits<double>::infinity()), 0.0);
  EXPECT_EQ(singularity_factor(std::numeric_limits<double>::quiet_NaN()), 0.0);
  // The geometric mean of both limits is the middle of the logarithms.
  const double middle = std::sqrt(kFullForceCondition * kNoForceCondition);
  EXPECT_NEAR(singularity_factor(middle), 0.5, 4.0 * std::numeric_limits<double>::epsilon());
  double last = 1.0;
  for (double condition = 1.0; condition < 25.0; condition += 0.125) {
    const double factor = singularity_factor(condition);
    EXPECT_LE(factor, last);
    EXPECT_LE(last - factor, 0.125);  // no step
    last = factor;
  }
}

}  // namespace
}  // namespace palpate
