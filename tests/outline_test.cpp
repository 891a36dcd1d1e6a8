// What a hand can get at of curves that run inside one another.

#include "engine/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kSmall_m = 1e-3;

struct Rectangle {
  double x, y, half_x, half_y;

  bool holds(double px, double py, double within) const {
    return std::abs(px - x) < half_x - within && std::abs(py - y) < half_y - within;
  }
};

// Material on the left, in the plane that the rotation turns z = 0 to.
Polyline curve_of(const Rectangle& r, const Quat& rotation = Quat::Identity()) {
  Polyline curve;
  curve.closed = true;
  for (const auto& [sx, sy] :
       std::array<std::pair<int, int>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    curve.points_m.push_back(rotation * Vec3(r.x + sx * r.half_x, r.y + sy * r.half_y, 0.0));
  }
  return curve;
}

TEST(Outlines, OfWhatOverlapsIsThatOfTheUnion) {
  Random random(8201);
  for (int i = 0; i < 50; ++i) {
    const Quat rotation = random.rotation();
    const Vec3 normal = rotation * Vec3::UnitZ();
    // A cross, and a bar across the end of another.
    const auto cross =
        outlines({curve_of({0, 0, 0.1, 0.02}, rotation), curve_of({0, 0, 0.03, 0.08}, rotation)},
                 normal, kSmall_m);
    ASSERT_EQ(cross.size(), 1u);
    EXPECT_TRUE(cross[0].curve.closed);
    EXPECT_FALSE(cross[0].has_two_sides);
    EXPECT_NEAR(length_m(cross[0].curve), 4 * (0.1 + 0.08), 1e-8);
    const auto tee =
        outlines({curve_of({0, 0, 0.1, 0.02}, rotation), curve_of({0.1, 0, 0.01, 0.05}, rotation)},
                 normal, kSmall_m);
    ASSERT_EQ(tee.size(), 1u);
    EXPECT_NEAR(length_m(tee[0].curve), 2 * (0.21 + 0.1), 1e-8);
  }
}

TEST(Outlines, LeaveOutWhatIsInsideAndKeepTheRestToTheBit) {
  const Polyline outer = curve_of({0, 0, 0.1, 0.1});
  const Polyline inner = curve_of({0.02, 0, 0.05, 0.05});
  const Polyline apart = curve_of({0.5, 0, 0.05, 0.05});
  Polyline cavity = curve_of({0, 0, 0.08, 0.08});
  std::reverse(cavity.points_m.begin(), cavity.points_m.end());
  const auto solid = outlines({outer, inner, apart}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(solid.size(), 2u);
  EXPECT_EQ(solid[0].curve.points_m, outer.points_m);
  EXPECT_EQ(solid[1].curve.points_m, apart.points_m);
  // In a cavity nothing is hidden.
  EXPECT_EQ(outlines({outer, cavity, inner}, Vec3::UnitZ(), kSmall_m).size(), 3u);
}

TEST(Outlines, OfASheetHaveTwoSidesAndEndWhereItEntersASolid) {
  const Polyline sheet{{Vec3(0, 0, 0), Vec3(0.3, 0, 0)}, false};
  const auto alone = outlines({sheet}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_TRUE(alone[0].has_two_sides);
  EXPECT_EQ(alone[0].curve.points_m, sheet.points_m);
  const auto stuck = outlines({curve_of({0, 0, 0.1, 0.005}), sheet}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(stuck.size(), 2u);
  const auto out =
      std::find_if(stuck.begin(), stuck.end(), [](const Outline& o) { return o.has_two_sides; });
  ASSERT_NE(out, stuck.end());
  EXPECT_NEAR(length_m(out->curve), 0.2, 1e-8);
}

// A shell without a bottom stands on a box: their outline goes over both. What stands in front of a
// bent sheet, in a bowl, is not hidden.
TEST(Outlines, TakeAShellForWhatItHasBehindIt) {
  const Polyline shell{
      {Vec3(0.05, 0.1, 0), Vec3(0.05, 0.15, 0), Vec3(-0.05, 0.15, 0), Vec3(-0.05, 0.1, 0)}, false};
  const auto found = outlines({curve_of({0, 0, 0.1, 0.1001}), shell}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].curve.closed);
  EXPECT_NEAR(length_m(found[0].curve), 0.8 + 2 * 0.05, 1e-3);
  const Polyline bowl{{Vec3(0.1, 0.1, 0), Vec3(0.1, 0, 0), Vec3(-0.1, 0, 0), Vec3(-0.1, 0.1, 0)},
                      false};
  const auto spoon = outlines({bowl, curve_of({0, 0.05, 0.02, 0.02})}, Vec3::UnitZ(), kSmall_m);
  EXPECT_EQ(spoon.size(), 2u);
}

// Against every place of every side, asked on its own.
TEST(Outlines, HoldWhatIsOutsideOfAllAndNothingElse) {
  Random random(8202);
  for (int i = 0; i < 100; ++i) {
    std::vector<Rectangle> rectangles;
    std::vector<Polyline> curves;
    for (int k = 0; k < 6; ++k) {
      rectangles.push_back({random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1),
                            random.uniform(0.02, 0.08), random.uniform(0.02, 0.08)});
      curves.push_back(curve_of(rectangles.back()));
    }
    const auto is_hidden = [&](const Vec3& p, double within) {
      return std::any_of(rectangles.begin(), rectangles.end(),
                         [&](const Rectangle& r) { return r.holds(p.x(), p.y(), within); });
    };
    double free_m = 0.0;
    for (const Polyline& curve : curves) {
      constexpr int kSteps = 4000;
      for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 way = curve.points_m[(k + 1) % 4] - curve.points_m[k];
        for (int n = 0; n < kSteps; ++n) {
          if (!is_hidden(curve.points_m[k] + (n + 0.5) / kSteps * way, 1e-9))
            free_m += way.norm() / kSteps;
        }
      }
    }
    double found_m = 0.0;
    for (const Outline& outline : outlines(curves, Vec3::UnitZ(), kSmall_m)) {
      found_m += length_m(outline.curve);
      EXPECT_TRUE(outline.curve.closed);
      for (const Vec3& p : outline.curve.points_m) EXPECT_FALSE(is_hidden(p, kSmall_m));
    }
    EXPECT_NEAR(found_m, free_m, 20 * kSmall_m) << i;
  }
}

}  // namespace
}  // namespace palpate
