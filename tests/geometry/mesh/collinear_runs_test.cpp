#include "geometry/mesh/collinear_runs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

double distance_m(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double share = ab.squaredNorm() > 0.0 ? (p - a).dot(ab) / ab.squaredNorm() : 0.0;
  return (p - a - std::clamp(share, 0.0, 1.0) * ab).norm();
}

double distance_m(const Vec3& p, const std::vector<Vec3>& curve, bool closed) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + (closed ? 0 : 1) < curve.size(); ++i) {
    nearest_m = std::min(nearest_m, distance_m(p, curve[i], curve[(i + 1) % curve.size()]));
  }
  return nearest_m;
}

// A polygon in a random pose with randomly divided sides. Its corners are `corners`, in this order.
std::vector<Vec3> divided(const std::vector<Vec3>& corners, const RigidTransform& pose,
                          test::Random& random) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 side = corners[(i + 1) % corners.size()] - corners[i];
    std::vector<double> shares = {0.0};
    for (std::size_t k = random.index(6); k > 0; --k) shares.push_back(random.uniform(0.0, 1.0));
    std::sort(shares.begin(), shares.end());
    for (const double share : shares) points.push_back(pose.point(corners[i] + share * side));
  }
  return points;
}

TEST(CollinearRuns, KeepTheCornersOfAPolygonForAnyStart) {
  test::Random random(401);
  const std::vector<Vec3> corners = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {1, 1, 0}, {0, 2, 0}};
  for (int trial = 0; trial < 300; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    std::vector<Vec3> points = divided(corners, pose, random);
    const auto shift = static_cast<std::ptrdiff_t>(random.index(points.size()));
    std::rotate(points.begin(), points.begin() + shift, points.end());
    const std::vector<Vec3> kept =
        without_collinear_points(points, true, pose.direction(Vec3::UnitZ()), 1e-14);
    ASSERT_EQ(kept.size(), corners.size());
    for (const Vec3& corner : corners) {
      ASSERT_LE(distance_m(pose.point(corner), kept, true), 2e-14);
    }
  }
}

TEST(CollinearRuns, KeepTheEndsOfAnOpenCurve) {
  test::Random random(402);
  const RigidTransform pose = random.pose(1.0);
  std::vector<Vec3> line;
  for (int i = 0; i <= 10; ++i) line.push_back(pose.point(Vec3(0.1 * i, 0.0, 0.0)));
  const std::vector<Vec3> kept =
      without_collinear_points(line, false, pose.direction(Vec3::UnitZ()), 1e-14);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept.front(), line.front());
  EXPECT_EQ(kept.back(), line.back());
}

TEST(CollinearRuns, KeepASpikeThatTurnsBackOnItself) {
  const std::vector<Vec3> spike = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const std::vector<Vec3> kept = without_collinear_points(spike, false, Vec3::UnitZ(), 1e-14);
  const std::vector<Vec3> expected = {{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  EXPECT_EQ(kept, expected);
}

TEST(CollinearRuns, StayWithinToleranceOfAnyCurve) {
  test::Random random(403);
  for (int trial = 0; trial < 60; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const double tolerance_m = std::pow(10.0, random.uniform(-6.0, -1.0));
    const double step_rad = std::pow(10.0, random.uniform(-2.5, -1.0));
    const bool closed = random.index(2) == 0;
    const double noise_m = random.index(2) == 0 ? 0.0 : tolerance_m;
    std::vector<Vec3> curve;
    for (double a = 0.0; a < 2.0 * std::numbers::pi; a += step_rad) {
      const double radius_m = 1.0 + 0.3 * std::sin(3.0 * a) + noise_m * random.uniform(-1.0, 1.0);
      curve.push_back(pose.point(Vec3(radius_m * std::cos(a), radius_m * std::sin(a), 0.0)));
    }
    const std::vector<Vec3> kept =
        without_collinear_points(curve, closed, pose.direction(Vec3::UnitZ()), tolerance_m);
    ASSERT_LE(kept.size(), curve.size());
    for (const Vec3& point : curve) {
      ASSERT_LE(distance_m(point, kept, closed), 1.001 * tolerance_m)
          << "tolerance " << tolerance_m;
    }
  }
}

TEST(CollinearRuns, ReduceACurveWithinTheToleranceToOnePoint) {
  const std::vector<Vec3> dot = {{0, 0, 0}, {1e-3, 0, 0}, {1e-3, 1e-3, 0}};
  EXPECT_EQ(without_collinear_points(dot, true, Vec3::UnitZ(), 0.01).size(), 1u);
  EXPECT_EQ(without_collinear_points(dot, false, Vec3::UnitZ(), 0.01).size(), 1u);
  EXPECT_TRUE(without_collinear_points({}, true, Vec3::UnitZ(), 0.01).empty());
}

}  // namespace
}  // namespace palpate
