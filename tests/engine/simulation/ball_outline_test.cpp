// The parts of outlines that a ball touches, compared with closed forms and with the circle itself.

#include "engine/simulation/ball_outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// Tolerance for the legs of arcs and for detail left out, see ball_outline.cpp.
constexpr double kPerRadius = 0.02;

std::vector<Outline> touched_by_ball(const std::vector<Outline>& found, const Vec3& plane_normal,
                                     double radius_m) {
  auto touched = ball_outlines(found, plane_normal, radius_m);
  EXPECT_TRUE(touched) << "gave up";
  return touched ? std::move(*touched) : std::vector<Outline>();
}

struct ScaledPlane {
  RigidTransform pose;
  double size;

  Vec3 point(double x, double y) const { return pose.point(size * Vec3(x, y, 0.0)); }
  Vec3 normal() const { return pose.direction(Vec3::UnitZ()); }
};

ScaledPlane random_plane(Random& random) {
  const double size = std::pow(10.0, random.uniform(-3.0, 3.0));
  return {{random.rotation(), size * random.in_box(1.0)}, size};
}

// A block of 2 by 1 with a groove from its upper side, material on the left.
Outline grooved_block(double width, double depth, const ScaledPlane& placed) {
  const double w = 0.5 * width;
  Outline outline{{{}, true}, false};
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{
           {-1, 0}, {1, 0}, {1, 1}, {w, 1}, {w, 1 - depth}, {-w, 1 - depth}, {-w, 1}, {-1, 1}}) {
    outline.curve.points_m.push_back(placed.point(x, y));
  }
  return outline;
}

TEST(BallOutlines, BridgeAGrooveThatIsNarrowerThanTheBall) {
  Random random(8301);
  for (int i = 0; i < 300; ++i) {
    const ScaledPlane placed = random_plane(random);
    const double radius = random.uniform(0.05, 0.2);
    const double width = 2.0 * radius * random.uniform(0.01, 0.98);
    const auto found =
        touched_by_ball({grooved_block(width, 0.5, placed)}, placed.normal(), radius * placed.size);
    ASSERT_EQ(found.size(), 1u) << i;
    EXPECT_TRUE(found[0].curve.closed);
    const double arc = 2.0 * radius * std::asin(0.5 * width / radius);
    EXPECT_NEAR(length_m(found[0].curve) / placed.size, 6.0 - width + arc, kPerRadius * radius);
  }
}

TEST(BallOutlines, GoIntoAGrooveThatIsWiderAndRoundItsCorners) {
  Random random(8302);
  for (int i = 0; i < 300; ++i) {
    const ScaledPlane placed = random_plane(random);
    const double radius = random.uniform(0.05, 0.2);
    const double width = 2.0 * radius * random.uniform(1.02, 2.0);
    const double depth = radius * random.uniform(1.05, 2.0);
    const auto found = touched_by_ball({grooved_block(width, depth, placed)}, placed.normal(),
                                       radius * placed.size);
    ASSERT_EQ(found.size(), 1u) << i;
    const double rounded = 2.0 * (2.0 - std::numbers::pi / 2.0) * radius;
    EXPECT_NEAR(length_m(found[0].curve) / placed.size, 6.0 + 2.0 * depth - rounded,
                2.0 * kPerRadius * radius);
  }
}

TEST(BallOutlines, LeaveOutAHollowTooNarrowForTheBall) {
  Random random(8303);
  for (int i = 0; i < 100; ++i) {
    const ScaledPlane placed = random_plane(random);
    const auto square = [&](double half, bool hollow) {
      Outline outline{{{placed.point(-half, -half), placed.point(half, -half),
                        placed.point(half, half), placed.point(-half, half)},
                       true},
                      false};
      if (hollow) std::reverse(outline.curve.points_m.begin(), outline.curve.points_m.end());
      return outline;
    };
    const std::vector<Outline> box = {square(1.0, false), square(0.5, true)};
    const auto small = touched_by_ball(box, placed.normal(), 0.4 * placed.size);
    ASSERT_EQ(small.size(), 2u);
    EXPECT_NEAR(length_m(small[1].curve) / placed.size,
                4.0 * (1.0 - 2.0 * 0.4) + 2.0 * std::numbers::pi * 0.4, 0.02);
    const auto large = touched_by_ball(box, placed.normal(), 0.6 * placed.size);
    ASSERT_EQ(large.size(), 1u);
    EXPECT_NEAR(length_m(large[0].curve) / placed.size, 8.0, 1e-6);
    EXPECT_TRUE(touched_by_ball({box[1]}, placed.normal(), 1.2 * placed.size).empty());
  }
}

double distance_to(const Vec3& p, const Polyline& curve) {
  double nearest = HUGE_VAL;
  const std::vector<Vec3>& points = curve.points_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 way = points[(i + 1) % points.size()] - points[i];
    const double length2 = way.squaredNorm();
    const double at =
        length2 > 0.0 ? std::clamp((p - points[i]).dot(way) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (p - points[i] - at * way).norm());
  }
  return nearest;
}

double distance_to(const Vec3& p, const std::vector<Outline>& outlines) {
  double nearest = HUGE_VAL;
  for (const Outline& o : outlines) nearest = std::min(nearest, distance_to(p, o.curve));
  return nearest;
}

std::vector<Outline> random_union(Random& random, const ScaledPlane& placed) {
  std::vector<Polyline> curves;
  for (std::size_t k = 0; k < 2 + random.index(8); ++k) {
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    const double angle = random.uniform(0.0, 7.0);
    const double w = random.uniform(0.05, 0.6);
    const double h = random.uniform(0.05, 0.6);
    Polyline curve{{}, true};
    for (const auto& [u, v] :
         std::vector<std::pair<double, double>>{{-w, -h}, {w, -h}, {w, h}, {-w, h}}) {
      curve.points_m.push_back(placed.point(x + u * std::cos(angle) - v * std::sin(angle),
                                            y + u * std::sin(angle) + v * std::cos(angle)));
    }
    curves.push_back(std::move(curve));
  }
  return *outlines(curves, placed.normal(), 1e-9 * placed.size);
}

// A place of an outline must be included if the circle that touches it there meets nothing else,
// and must not be if the circle overlaps a solid.
TEST(BallOutlines, ContainExactlyThePlacesThatACircleTouches) {
  Random random(8304);
  int touched = 0;
  int hidden = 0;
  for (int i = 0; i < 150; ++i) {
    const ScaledPlane placed = random_plane(random);
    const std::vector<Outline> all = random_union(random, placed);
    const double radius = placed.size * std::pow(10.0, random.uniform(-2.0, 0.5));
    const auto found = touched_by_ball(all, placed.normal(), radius);
    for (const Outline& outline : all) {
      const auto& points = outline.curve.points_m;
      for (int k = 0; k < 20; ++k) {
        const std::size_t n = random.index(points.size());
        const Vec3 way = points[(n + 1) % points.size()] - points[n];
        const Vec3 p = points[n] + random.uniform(0.0, 1.0) * way;
        const Vec3 centre = p + radius * way.cross(placed.normal()).normalized();
        const double clear = distance_to(centre, all);
        const double off = distance_to(p, found);
        if (clear > (1.0 - 1e-9) * radius) {
          ++touched;
          EXPECT_LE(off, kPerRadius * radius) << i;
        } else if (clear < 0.9 * radius) {
          ++hidden;
          EXPECT_GT(off, 0.0) << i;
        }
      }
    }
    // A ball that follows the outlines is never inside a solid.
    for (const Outline& outline : found) {
      const auto& points = outline.curve.points_m;
      for (std::size_t n = 0; n < points.size(); ++n) {
        const Vec3 way = points[(n + 1) % points.size()] - points[n];
        if (way.norm() < kPerRadius * radius) continue;  // within the error of an arc's legs
        const Vec3 centre =
            points[n] + 0.5 * way + radius * way.cross(placed.normal()).normalized();
        EXPECT_GE(distance_to(centre, all), (1.0 - kPerRadius) * radius) << i;
      }
    }
  }
  EXPECT_GT(touched, 300);
  EXPECT_GT(hidden, 300);
}

}  // namespace
}  // namespace palpate
