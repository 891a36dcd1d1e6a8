#include "geometry/exact/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

// The oracle: corners on a grid of integers below 2^60, where a 128-bit cross product is exact.
__extension__ typedef __int128 Int128;
using GridPoint = std::array<std::int64_t, 3>;

std::array<Int128, 3> exact_cross(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  std::array<Int128, 3> cross;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t i = (axis + 1) % 3;
    const std::size_t j = (axis + 2) % 3;
    cross[axis] = Int128(b[i] - a[i]) * (c[j] - a[j]) - Int128(b[j] - a[j]) * (c[i] - a[i]);
  }
  return cross;
}

bool is_zero(const std::array<Int128, 3>& cross) {
  return cross[0] == 0 && cross[1] == 0 && cross[2] == 0;
}

// Exact, because a grid coordinate has at most 53 significant bits and the unit is a power of two.
Vec3 to_vec3(const GridPoint& p, double unit = 1.0) {
  return {static_cast<double>(p[0]) * unit, static_cast<double>(p[1]) * unit,
          static_cast<double>(p[2]) * unit};
}

GridPoint random_grid_point(test::Random& random, double half_extent) {
  GridPoint p;
  for (std::int64_t& coordinate : p) {
    coordinate = static_cast<std::int64_t>(random.uniform(-half_extent, half_extent));
  }
  return p;
}

GridPoint along(const GridPoint& origin, const GridPoint& step, std::int64_t count) {
  return {origin[0] + count * step[0], origin[1] + count * step[1], origin[2] + count * step[2]};
}

std::int64_t random_count(test::Random& random) {
  return static_cast<std::int64_t>(random.index(1u << 21)) - (1 << 20);
}

double ulp(double x) {
  const double size = std::abs(x);
  return std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
}

// Compares each component with the exact cross product, normalised in long double.
void expect_normal(const std::array<Int128, 3>& cross, const Vec3& normal) {
  std::array<long double, 3> exact;
  for (std::size_t i = 0; i < 3; ++i) exact[i] = static_cast<long double>(cross[i]);
  const long double norm = std::hypot(exact[0], exact[1], exact[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto expected = static_cast<double>(exact[i] / norm);
    EXPECT_LE(std::abs(normal[static_cast<int>(i)] - expected), 4.0 * ulp(expected))
        << "component " << i << " of " << expected;
  }
}

// A sliver: b far from a along a line, c near that line within one grid unit per axis.
struct Sliver {
  GridPoint a, b, c;
};
Sliver random_sliver(test::Random& random, double half_length) {
  Sliver s;
  s.a = random_grid_point(random, half_length);
  s.b = random_grid_point(random, half_length);
  const double share = random.uniform(-1.0, 2.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const double on_line =
        static_cast<double>(s.a[i]) + share * static_cast<double>(s.b[i] - s.a[i]);
    s.c[i] = std::llround(on_line);
  }
  return s;
}

// Three corners on a line through the origin: a near the origin, b and c so far away that their
// doubles cannot represent the units.
Sliver random_sliver_of_mixed_size(test::Random& random) {
  const GridPoint origin = {0, 0, 0};
  const GridPoint step = random_grid_point(random, 0x1p9);
  const auto near = static_cast<std::int64_t>(random.index(200));
  const auto far = [&] { return static_cast<std::int64_t>(random.index(1u << 30)) << 20; };
  const std::int64_t b = far();
  return {along(origin, step, near), along(origin, step, b), along(origin, step, -far())};
}

TEST(ExactlyCollinear, FindsCornersOnOneLineInAnyDirection) {
  test::Random random(101);
  for (int trial = 0; trial < 20000; ++trial) {
    const GridPoint a = random_grid_point(random, 0x1p45);
    const GridPoint step = random_grid_point(random, 0x1p25);
    const Vec3 b = to_vec3(along(a, step, random_count(random)));
    const Vec3 c = to_vec3(along(a, step, random_count(random)));
    ASSERT_TRUE(exactly_collinear(to_vec3(a), b, c)) << trial;
  }
}

TEST(ExactlyCollinear, DetectsOneUnitInTheLastPlace) {
  test::Random random(102);
  int seen_with_area = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const GridPoint a = random_grid_point(random, 0x1p45);
    const GridPoint step = random_grid_point(random, 0x1p25);
    const GridPoint b = along(a, step, random_count(random));
    GridPoint c = along(a, step, random_count(random));
    c[random.index(3)] += random.index(2) == 0 ? 1 : -1;
    const bool expected = is_zero(exact_cross(a, b, c));
    ASSERT_EQ(exactly_collinear(to_vec3(a), to_vec3(b), to_vec3(c)), expected) << trial;
    seen_with_area += expected ? 0 : 1;
  }
  EXPECT_GT(seen_with_area, 19000);
}

TEST(ExactlyCollinear, DoesNotDependOnOrderOrScale) {
  test::Random random(103);
  for (int trial = 0; trial < 3000; ++trial) {
    const Sliver s = random_sliver(random, 40.0);  // a coarse grid: many slivers are degenerate
    const bool expected = is_zero(exact_cross(s.a, s.b, s.c));
    for (const double unit : {1.0, 0x1p-1074, 0x1p-1030, 0x1p-540, 0x1p300, 0x1p1017}) {
      std::array<Vec3, 3> corners = {to_vec3(s.a, unit), to_vec3(s.b, unit), to_vec3(s.c, unit)};
      for (int turn = 0; turn < 3; ++turn) {
        ASSERT_EQ(exactly_collinear(corners[0], corners[1], corners[2]), expected) << unit;
        ASSERT_EQ(exactly_collinear(corners[0], corners[2], corners[1]), expected) << unit;
        std::rotate(corners.begin(), corners.begin() + 1, corners.end());
      }
    }
  }
}

TEST(ExactlyCollinear, IsExactForCornersOfVeryDifferentMagnitude) {
  const Vec3 direction(3.0, -5.0, 7.0);
  const Vec3 far = direction * 0x1p400;
  const Vec3 near = direction * 0x1p-400;
  EXPECT_TRUE(exactly_collinear(near, far, Vec3::Zero()));
  EXPECT_TRUE(exactly_collinear(far, near, -far));
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 beside = near;
    beside[axis] = std::nextafter(beside[axis], 1e300);
    EXPECT_FALSE(exactly_collinear(beside, far, Vec3::Zero())) << axis;
    EXPECT_FALSE(exactly_collinear(far, -far, beside)) << axis;
  }
}

// Differences of the corners have up to 61 bits, so that rounding the differences would give wrong
// results.
TEST(ExactlyCollinear, IsExactIfDifferencesDoNotFitADouble) {
  test::Random random(108);
  for (int trial = 0; trial < 20000; ++trial) {
    Sliver s = random_sliver_of_mixed_size(random);
    ASSERT_TRUE(exactly_collinear(to_vec3(s.a), to_vec3(s.b), to_vec3(s.c))) << trial;
    ASSERT_TRUE(exactly_collinear(to_vec3(s.c), to_vec3(s.a), to_vec3(s.b))) << trial;
    s.a[random.index(3)] += 1;
    const bool expected = is_zero(exact_cross(s.a, s.b, s.c));
    ASSERT_EQ(exactly_collinear(to_vec3(s.a), to_vec3(s.b), to_vec3(s.c)), expected) << trial;
    ASSERT_EQ(exactly_collinear(to_vec3(s.b), to_vec3(s.c), to_vec3(s.a)), expected) << trial;
  }
}

TEST(ExactlyCollinear, FindsRepeatedCorners) {
  test::Random random(104);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 a = random.in_box(1.0);
    const Vec3 b = random.in_box(1e6);
    EXPECT_TRUE(exactly_collinear(a, a, b));
    EXPECT_TRUE(exactly_collinear(a, b, a));
    EXPECT_TRUE(exactly_collinear(b, a, a));
    EXPECT_TRUE(exactly_collinear(a, a, a));
  }
  EXPECT_TRUE(exactly_collinear(Vec3::Zero(), Vec3::Zero(), Vec3(-0.0, 0.0, -0.0)));
}

TEST(AccurateUnitNormal, IsWithinFourUlpHoweverThinTheTriangle) {
  test::Random random(105);
  int checked = 0;
  for (const double half_length : {0x1p8, 0x1p27, 0x1p36, 0x1p46, 0x1p49}) {
    for (int trial = 0; trial < 5000; ++trial) {
      const Sliver s = random_sliver(random, half_length);
      const std::array<Int128, 3> cross = exact_cross(s.a, s.b, s.c);
      if (is_zero(cross)) continue;
      const double unit = std::ldexp(1.0, static_cast<int>(random.index(600)) - 300);
      expect_normal(
          cross, accurate_unit_normal(to_vec3(s.a, unit), to_vec3(s.b, unit), to_vec3(s.c, unit)));
      ++checked;
    }
  }
  EXPECT_GT(checked, 20000);
}

TEST(AccurateUnitNormal, IsAccurateForSliversFarFromTheOrigin) {
  test::Random random(106);
  for (int trial = 0; trial < 5000; ++trial) {  // aspect ratio 1e8, a thousand lengths away
    const GridPoint far = random_grid_point(random, 0x1p49);
    Sliver s = random_sliver(random, 0x1p38);
    for (GridPoint* corner : {&s.a, &s.b, &s.c}) *corner = along(*corner, far, 1);
    const std::array<Int128, 3> cross = exact_cross(s.a, s.b, s.c);
    if (is_zero(cross)) continue;
    expect_normal(cross, accurate_unit_normal(to_vec3(s.a), to_vec3(s.b), to_vec3(s.c)));
  }
}

TEST(AccurateUnitNormal, IsAccurateIfDifferencesDoNotFitADouble) {
  test::Random random(109);
  for (int trial = 0; trial < 5000; ++trial) {
    Sliver s = random_sliver_of_mixed_size(random);
    s.a[random.index(3)] += 1;
    const std::array<Int128, 3> cross = exact_cross(s.a, s.b, s.c);
    if (is_zero(cross)) continue;
    expect_normal(cross, accurate_unit_normal(to_vec3(s.a), to_vec3(s.b), to_vec3(s.c)));
  }
}

TEST(AccurateUnitNormal, StaysFiniteAndUnitAtTheEndsOfTheRange) {
  const GridPoint a = {1, 2, 3};
  const GridPoint b = {40, -7, 5};
  const GridPoint c = {-3, 11, 60};
  for (const double unit : {0x1p-1074, 0x1p-1000, 0x1p-600, 0x1p600, 0x1p1017}) {
    expect_normal(exact_cross(a, b, c),
                  accurate_unit_normal(to_vec3(a, unit), to_vec3(b, unit), to_vec3(c, unit)));
  }
}

TEST(AccurateUnitNormal, ChangesSignIfTheTriangleIsReversed) {
  test::Random random(107);
  for (int trial = 0; trial < 1000; ++trial) {
    const Vec3 a = random.in_box(1.0);
    const Vec3 b = random.in_box(1.0);
    const Vec3 c = random.in_box(1.0);
    const Vec3 front = accurate_unit_normal(a, b, c);
    EXPECT_GT(front.dot((b - a).cross(c - a)), 0.0);
    const Vec3 back = accurate_unit_normal(a, c, b);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(front[i], -back[i]);
  }
}

}  // namespace
}  // namespace palpate
