// Coverage of a curve by a moving point, compared with separate tests of steps along the curve.

#include "engine/simulation/path_coverage.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

// The share of steps along a curve with a point within near_m, and the share that half a step
// leaves undecided.
double stepped_share(const std::vector<Vec3>& curve, const std::vector<Vec3>& points,
                     double near_m) {
  constexpr int kSteps = 200;
  double length = 0.0;
  double covered = 0.0;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const Vec3 way = curve[i + 1] - curve[i];
    for (int k = 0; k < kSteps; ++k) {
      const Vec3 place = curve[i] + (k + 0.5) / kSteps * way;
      const bool is_near = std::any_of(points.begin(), points.end(),
                                       [&](const Vec3& p) { return (p - place).norm() <= near_m; });
      length += way.norm();
      if (is_near) covered += way.norm();
    }
  }
  return covered / length;
}

TEST(CurveCoverage, IsTheShareOfTheLengthNearAPoint) {
  test::Random random(7301);
  for (int i = 0; i < 200; ++i) {
    const double size_m = std::pow(10.0, random.uniform(-3.0, 3.0));
    const Vec3 middle = random.in_box(10.0 * size_m);
    const double near_m = size_m * std::pow(10.0, random.uniform(-2.0, 0.0));
    std::vector<Vec3> curve;
    for (std::size_t k = 0; k < 2 + random.index(20); ++k) {
      curve.push_back(middle + random.in_box(size_m));
    }
    std::vector<Vec3> points;
    CurveCoverage coverage(curve, near_m);
    EXPECT_EQ(coverage.share(), 0.0);
    for (std::size_t k = 0; k < random.index(60); ++k) {
      points.push_back(middle + random.in_box(1.2 * size_m));
      coverage.add(points.back());
    }
    EXPECT_NEAR(coverage.share(), stepped_share(curve, points, near_m), 0.01) << i;
  }
}

TEST(CurveCoverage, CountsNothingTwice) {
  CurveCoverage coverage({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 0)}, 0.1);
  for (int pass = 0; pass < 3; ++pass) {
    for (const double x : {0.2, 0.3, 0.25}) coverage.add({x, 0.0, 0.0});
  }
  EXPECT_NEAR(coverage.share(), 0.3, 1e-12);
}

TEST(CurveCoverage, IsOneForAFollowedCurveAndZeroWithoutLength) {
  CurveCoverage whole({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)}, 0.02);
  for (double s = 0.0; s <= 2.0; s += 0.01) {
    whole.add(s < 1.0 ? Vec3(s, 0.01, 0.0) : Vec3(1.01, s - 1.0, 0.0));
  }
  whole.add({1.0, 1.0, 0.0});
  EXPECT_EQ(whole.share(), 1.0);
  for (const std::vector<Vec3>& curve :
       {std::vector<Vec3>{}, {Vec3::Ones()}, {Vec3::Ones(), Vec3::Ones()}}) {
    CurveCoverage none(curve, 0.1);
    none.add(Vec3::Ones());
    EXPECT_EQ(none.share(), 0.0);
  }
}

}  // namespace
}  // namespace palpate
