// The hard cases of god-object rendering with difficult meshes: many-sided apexes, saddles, slivers
// and cracks, at any position and size. JudgedProxy judges each tick: finite, passive, and with a
// path that touches no triangle in exact arithmetic.

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/haptics/proxy/hard_case_proxy.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::JudgedProxy;
using test::kDeg;
using test::kRelativeAccuracy;
using test::kTick_s;
using test::on_lattice;
using test::OwnedWorld;
using test::posed;
using test::radius_name;
using test::Random;
using test::Soup;
using test::trials;

// Moves to a constant goal until a tick converges. A tick that ran out of iterations or work has
// not converged; the next tick continues from its position.
ProxyState settle(JudgedProxy& proxy, const Vec3& goal_scene, int most_ticks) {
  ProxyState state = proxy.move_to(goal_scene);
  for (int tick = 1; tick < most_ticks && state.capped; ++tick) state = proxy.move_to(goal_scene);
  return state;
}

// ---- 5 apexes of 64 and 1000 triangles ---------------------------------------------------------

struct ApexCase {
  int valence;
  double radius_m;
};

void PrintTo(const ApexCase& c, std::ostream* out) {
  *out << "valence " << c.valence << ", radius " << c.radius_m;
}

class HardCase05_Apex : public testing::TestWithParam<ApexCase> {
 protected:
  static constexpr double kSlope = 0.75;
};

// The distance of a point proxy outside a convex shape from a local minimum of the distance to the
// goal. The local minima are the projections of the goal onto the planes of faces.
double distance_to_a_projection(const Soup& soup, const Vec3& proxy, const Vec3& goal) {
  double least = (proxy - goal).norm();  // without contact
  for (const Triangle& t : soup.triangles) {
    const Vec3& a = soup.positions[t[0]];
    const Vec3 normal = (soup.positions[t[1]] - a).cross(soup.positions[t[2]] - a).normalized();
    const double height = normal.dot(goal - a);
    if (height > 0.0) continue;
    least = std::min(least, (proxy - (goal - height * normal)).norm());
  }
  return least;
}

TEST_P(HardCase05_Apex, StopsTheProxyFromOutside) {
  const auto [valence, radius] = GetParam();
  Random random(107);
  for (int n = 0; n < (valence > 100 ? 2 : 10); ++n) {
    const Soup soup = posed(test::pyramid_soup(valence, kSlope), random.pose(1.0));
    const OwnedWorld world(soup, {}, radius);
    JudgedProxy proxy(world, radius);
    const Vec3 apex = soup.positions.front();
    const Vec3 up = (apex - soup.positions.back()).normalized();
    proxy.place(apex + (radius + 0.1) * up);
    proxy.move_to(apex);  // exactly on it
    for (int tick = 0; tick < trials(200); ++tick) {
      const double reach = std::pow(10.0, random.uniform(-9.0, -1.0));
      const Vec3 goal = apex + reach * random.unit_vector();
      const ProxyState state = proxy.move_to(goal);
      if (radius == 0.0 && !state.capped) {
        ASSERT_LE(distance_to_a_projection(soup, state.proxy, goal),
                  kRelativeAccuracy * proxy.size_m())
            << "tick " << tick << " reach " << reach;
      }
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " tick " << tick;
    }
  }
}

// From inside, the apex itself holds the proxy for goals in the cone of the outward normals.
TEST_P(HardCase05_Apex, HoldsTheProxyFromInside) {
  const auto [valence, radius] = GetParam();
  constexpr int kTicksAtAnApex = 1000;  // 1000 triangles need the work of about a hundred ticks
  Random random(108);
  // The distance of a face of the fan from a point on the axis is cosine * depth below the apex.
  const double cosine = 1.0 / std::hypot(1.0, kSlope / std::cos(std::numbers::pi / valence));
  for (int n = 0; n < (valence > 100 ? 2 : 10); ++n) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::pyramid_soup(valence, kSlope), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    const Vec3 held(0.0, 0.0, -radius / cosine);
    proxy.place(pose.point({0.0, 0.0, -0.6 * kSlope}));
    for (int tick = 0; tick < trials(200); ++tick) {
      const double above = std::pow(10.0, random.uniform(-4.0, -0.5));
      const double off_axis = random.uniform(0.0, 0.9) * kSlope * above;
      const double angle = random.uniform(0.0, 2 * std::numbers::pi);
      const Vec3 goal = held + Vec3(off_axis * std::cos(angle), off_axis * std::sin(angle), above);
      const ProxyState state = settle(proxy, pose.point(goal), kTicksAtAnApex);
      ASSERT_FALSE(state.capped);
      ASSERT_LE((state.proxy - pose.point(held)).norm(), kRelativeAccuracy * proxy.size_m())
          << "tick " << tick << " after " << state.iterations << " iterations";
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " tick " << tick;
      if (tick % 10 == 9)
        proxy.place(
            pose.point(held + 0.1 * kSlope * random.in_box(0.5) - Vec3(0, 0, 0.2 * kSlope)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Valence, HardCase05_Apex,
                         testing::Values(ApexCase{64, 0.0}, ApexCase{1000, 0.0}, ApexCase{64, 0.02},
                                         ApexCase{1000, 0.02}),
                         [](const auto& given) {
                           return std::to_string(given.param.valence) +
                                  (given.param.radius_m == 0.0 ? "_Point" : "_Sphere");
                         });

// ---- 6 saddles ---------------------------------------------------------------------------------

class HardCase06_Saddle : public testing::TestWithParam<double> {};

// A fan of 4 * waves triangles; the first position is its centre.
Soup random_saddle(int waves, Random& random) {
  const double steepness = random.uniform(0.01, 1.0);
  const double turn = 0.5 * std::numbers::pi;  // per triangle: up, level, down, level
  const auto height = [&](int i) { return steepness * std::cos(turn * i); };
  return posed(test::fan_soup(4 * waves, height), random.pose(1.0));
}

Vec3 axis_of(const Soup& saddle) {
  const Vec3& middle = saddle.positions[0];
  const std::size_t valence = saddle.positions.size() - 1;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < valence; ++i) {
    const Vec3& next = saddle.positions[1 + (i + 1) % valence];
    sum += (saddle.positions[1 + i] - middle).cross(next - middle);
  }
  return sum.normalized();
}

// At the centre of a saddle, more than three faces are active or nearly active. Every piece of
// every path must reduce the distance to the goal; JudgedProxy tests this.
TEST_P(HardCase06_Saddle, IsMonotone) {
  const double radius = GetParam();
  Random random(109);
  for (int n = 0; n < trials(150); ++n) {
    const Soup soup = random_saddle(2 + n % 5, random);
    const OwnedWorld world(soup, {}, radius);
    JudgedProxy proxy(world, radius);
    const Vec3& middle = soup.positions.front();
    proxy.place(middle + (n % 2 ? 0.5 : -0.5) * axis_of(soup));
    for (int tick = 0; tick < 100; ++tick) {
      const double reach = std::pow(10.0, random.uniform(-9.0, -1.0));
      proxy.move_to(middle + reach * random.unit_vector());
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " tick " << tick;
    }
  }
}

TEST_P(HardCase06_Saddle, KeepsAConvergedProxyAtRest) {
  const double radius = GetParam();
  Random random(115);
  for (int n = 0; n < trials(400); ++n) {
    const Soup soup = random_saddle(2 + n % 5, random);
    const OwnedWorld world(soup, {}, radius);
    JudgedProxy proxy(world, radius);
    const Vec3& middle = soup.positions.front();
    proxy.place(middle + (n % 2 ? 0.5 : -0.5) * axis_of(soup));
    for (int trial = 0; trial < 20; ++trial) {
      const double reach = std::pow(10.0, random.uniform(-6.0, -1.0));
      const Vec3 goal = middle + reach * random.unit_vector();
      const ProxyState state = proxy.move_to(goal);
      if (state.capped) continue;
      const ProxyState held = proxy.move_to(goal);
      ASSERT_LE((held.proxy - state.proxy).norm(), kRelativeAccuracy * proxy.size_m())
          << "pose " << n << " trial " << trial << " after " << state.iterations << " iterations";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase06_Saddle, testing::Values(0.0, 0.02), radius_name);

// ---- 7 slivers and invalid triangles -----------------------------------------------------------

class HardCase07_BadTriangles : public testing::TestWithParam<double> {
 protected:
  static constexpr double kHalf = 0.1;
  static constexpr int kSlivers = 64;
  static constexpr double kSliverWidth = kHalf * 1e-8;

  // A square of two fans of slivers, with additional triangles: without area, duplicate, or
  // overlapping in its plane.
  static Soup bad_square(Random& random) {
    Soup soup;
    test::add_sliver_fan(soup, kHalf, -kHalf, 0.0, kSlivers);
    test::add_sliver_fan(soup, kHalf, kHalf, 0.0, kSlivers);
    for (int i = 0; i < 50; ++i) {
      const Triangle t = soup.triangles[random.index(soup.triangles.size())];
      const Vec3 a = soup.positions[t[0]];
      const Vec3 b = soup.positions[t[1]];
      soup.triangles.push_back({t[1], t[2], t[0]});
      soup.triangles.push_back({t[2], t[1], t[0]});
      soup.add(a, b, a);
      soup.add(a, b, 0.5 * (a + b));
      soup.add(a, a, a);
      soup.add(in_square(random), in_square(random), in_square(random));
    }
    return soup;
  }
  static Vec3 in_square(Random& random) { return random.in_box(kHalf).cwiseProduct(Vec3(1, 1, 0)); }
};

TEST_P(HardCase07_BadTriangles, BehaveLikeAFlatSquare) {
  const double radius = GetParam();
  constexpr int kTicksOnASquare = 20;
  Random random(110);
  for (int n = 0; n < trials(12); ++n) {
    const RigidTransform pose = random.pose(0.5);
    const OwnedWorld world(posed(bad_square(random), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    proxy.place(pose.point({0.0, 0.0, 0.05}));
    // The rounding of corners one metre from the origin tilts a sliver by up to this angle.
    const double tilt_rad = 8 * 0x1p-52 / kSliverWidth;
    const double stand_off = 2 * proxy.scale().stand_off_m;
    const double allowed = kRelativeAccuracy * proxy.size_m();
    for (int tick = 0; tick < 200; ++tick) {
      Vec3 goal = 0.9 * in_square(random);
      // Half of the goals are within a fan of slivers.
      const double into_fan = random.uniform(0.0, 1.0);
      if (tick % 2 == 0) {
        const Vec3 base(-kHalf + random.uniform(0.0, kSlivers) * kSliverWidth, -kHalf, 0.0);
        goal = base + (0.05 + 0.9 * into_fan) * (Vec3(kHalf, 0, 0) - base);
      }
      goal.z() = std::pow(10.0, random.uniform(-9.0, -2.0)) * (tick % 5 == 0 ? 1.0 : -1.0);
      const ProxyState state = settle(proxy, pose.point(goal), kTicksOnASquare);
      const Vec3 expected(goal.x(), goal.y(), std::max(radius, goal.z()));
      const double depth = std::max(0.0, expected.z() - goal.z());
      // Tilted faces move the solution sideways by that angle times the depth. The height of a
      // sphere over each face varies by a stand-off, and a position that is farther from the goal
      // by one stand-off is this far aside.
      const double aside = radius == 0.0 ? 0.0 : std::sqrt(2 * depth * stand_off);
      const Vec3 error = pose.inverse_point(state.proxy) - expected;
      ASSERT_LE(error.norm(), allowed + tilt_rad * depth + aside)
          << "tick " << tick << " goal " << goal.transpose();
      ASSERT_LE(std::abs(error.z()), allowed) << "tick " << tick << " goal " << goal.transpose();
      ASSERT_EQ(proxy.verdict(), "") << "pose " << n << " tick " << tick;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase07_BadTriangles, testing::Values(0.0, 5e-3), radius_name);

// ---- 8 T-junctions and cracks ------------------------------------------------------------------

// A sphere moves over strips with gaps between them. The widest hole is the end of a gap of width w
// at another gap: a circle of radius 5/8 w fits in.
TEST(HardCase08_CracksAndTJunctions, HoldASphereThatIsWiderThanTheCrack) {
  const double radius = 5e-3;
  Random random(111);
  for (const double gap : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.5 * radius}) {
    const double lowest = std::sqrt(radius * radius - 25.0 / 64.0 * gap * gap);
    for (int n = 0; n < trials(20); ++n) {
      const RigidTransform pose = random.pose(1.0);
      const OwnedWorld world(posed(test::tiled_sheet_soup(0.2, 8, 8, gap), pose), {}, radius);
      JudgedProxy proxy(world, radius);
      for (int plunge = 0; plunge < 20; ++plunge) {
        proxy.place(pose.point({0.0, 0.0, 0.02}));
        for (int tick = 0; tick < 20; ++tick) {
          Vec3 goal = random.in_box(0.17);
          // Every other goal is over a gap along x.
          if (tick % 2 == 0) goal.y() = 0.05 * std::round(goal.y() / 0.05);
          goal.z() = -std::abs(goal.z());
          const ProxyState state = proxy.move_to(pose.point(goal));
          const double height = pose.inverse_point(state.proxy).z();
          ASSERT_GE(height, lowest - kRelativeAccuracy * proxy.size_m()) << "gap " << gap;
          ASSERT_LE(height, radius + kRelativeAccuracy * proxy.size_m()) << "gap " << gap;
          ASSERT_EQ(proxy.verdict(), "") << "gap " << gap << " pose " << n;
        }
      }
    }
  }
}

// A point moves over strips that touch exactly. The shear has whole numbers, so that corners stay
// on the edges that they divide. Each ray aims exactly at such a corner.
TEST(HardCase08_CracksAndTJunctions, HoldAPointWhereCornersLieExactlyOnEdges) {
  Random random(112);
  for (int n = 0; n < trials(200); ++n) {
    Mat3 shear;
    do {
      for (int k = 0; k < 9; ++k) shear(k) = static_cast<double>(random.index(9)) - 4.0;
    } while (shear.determinant() < 1.0);
    Soup soup = test::tiled_sheet_soup(0.25, 8, 8, 0.0);
    for (Vec3& p : soup.positions) p = shear * p;
    const OwnedWorld world(soup);
    JudgedProxy proxy(world);
    const Vec3 normal = shear.col(0).cross(shear.col(1));  // of whole numbers, and exact
    for (int trial = 0; trial < 100; ++trial) {
      const auto eighth = [&] { return 0x1p-5 * (static_cast<double>(random.index(13)) - 6.0); };
      const Vec3 corner = shear * Vec3(eighth(), eighth(), 0.0);
      const Vec3 start = corner + 0x1p-8 * normal + on_lattice(random.in_box(2e-3));
      proxy.place(start);
      proxy.move_to(2 * corner - start);
      ASSERT_EQ(proxy.verdict(), "") << "shear " << n << " trial " << trial;
      const Vec3 ended = proxy.proxy_scene();
      ASSERT_LT(test::orientation(Vec3::Zero(), shear.col(0), shear.col(1), ended), 0);
    }
  }
}

// ---- 9 scenes far away and of any size ---------------------------------------------------------

struct PlacedCase {
  double scale;
  double distance_m;  // distance of the scene's middle from the origin
  double radius;      // radius of the proxy, relative to the scale
};

void PrintTo(const PlacedCase& c, std::ostream* out) {
  *out << "scale " << c.scale << " at " << c.distance_m << " m, relative radius " << c.radius;
}

class HardCase09_FarAwayAndScaled : public testing::TestWithParam<PlacedCase> {};

// The same trajectory inside a polyhedron, once near the origin at its own size and once scaled and
// moved. The solution is a projection onto a convex set. Its two results may therefore differ by
// the stand-off and by the rounding of corners, goals and proxies, magnified at a corner between
// two faces.
TEST_P(HardCase09_FarAwayAndScaled, GivesTheSameTrajectoryToTheFloatFloor) {
  const PlacedCase c = GetParam();
  Random random(113);
  const Soup soup = posed(test::soup_of(icosphere(1, 1.0)), {random.rotation(), Vec3::Zero()});
  const Vec3 middle = c.distance_m * random.unit_vector();
  Soup moved = soup;
  for (Vec3& p : moved.positions) p = middle + c.scale * p;
  const OwnedWorld near_world(soup, {}, c.radius);
  const OwnedWorld far_world(moved, {}, c.scale * c.radius);
  JudgedProxy near_proxy(near_world, c.radius);
  JudgedProxy far_proxy(far_world, c.scale * c.radius);
  near_proxy.place(Vec3::Zero());
  far_proxy.place(middle);
  // Neighbouring faces of this polyhedron meet at 18 deg or more. If two faces move by e, their
  // common edge moves by e / sin(9 deg) at most, and this applies to both sides of the comparison.
  const double corner_gain = 2.0 / std::sin(9 * kDeg);
  const double coordinate_ulp = 0x1p-52 * (c.distance_m + 2.0 * c.scale) / c.scale;
  const double allowed = corner_gain * (near_proxy.scale().stand_off_m + 4 * coordinate_ulp);
  Vec3 at = Vec3::Zero();
  for (int tick = 0; tick < trials(2000); ++tick) {
    at = (at + random.in_box(0.1)).cwiseMin(1.2).cwiseMax(-1.2);
    const ProxyState here = near_proxy.move_to(at);
    const ProxyState there = far_proxy.move_to(middle + c.scale * at);
    const Vec3 mapped = (there.proxy - middle) / c.scale;
    ASSERT_LE((mapped - here.proxy).norm(), allowed) << "tick " << tick;
    ASSERT_EQ(near_proxy.verdict(), "");
    ASSERT_EQ(far_proxy.verdict(), "");
  }
}

TEST_P(HardCase09_FarAwayAndScaled, RestsAtALocalMinimumOutside) {
  const PlacedCase c = GetParam();
  Random random(114);
  Soup soup = posed(test::soup_of(icosphere(1, 1.0)), {random.rotation(), Vec3::Zero()});
  const Vec3 middle = c.distance_m * random.unit_vector();
  for (Vec3& p : soup.positions) p = middle + c.scale * p;
  const OwnedWorld world(soup, {}, c.scale * c.radius);
  JudgedProxy proxy(world, c.scale * c.radius);
  proxy.place(middle + c.scale * Vec3(0, 0, 1.5));
  // The rounding of corners at that distance tilts a face; its edges are longer than half the
  // radius.
  const double coordinate_ulp_m = 0x1p-52 * (c.distance_m + 2.0 * c.scale);
  const double allowed_m = 2 * proxy.scale().stand_off_m + 16 * coordinate_ulp_m;
  for (int tick = 0; tick < trials(2000); ++tick) {
    const double angle = 0.01 * tick;
    const Vec3 on_helix(std::cos(angle) * std::sin(0.01 + 1e-3 * tick), std::sin(angle) * 0.4,
                        std::cos(0.01 + 1e-3 * tick));
    const Vec3 goal = middle + c.scale * 0.9 * on_helix;
    const ProxyState state = proxy.move_to(goal);
    if (c.radius == 0.0) {
      ASSERT_LE(distance_to_a_projection(soup, state.proxy, goal), allowed_m) << "tick " << tick;
    }
    ASSERT_EQ(proxy.verdict(), "") << "tick " << tick;
  }
}

INSTANTIATE_TEST_SUITE_P(Places, HardCase09_FarAwayAndScaled,
                         testing::Values(PlacedCase{1e-3, 1e3, 0.0}, PlacedCase{1.0, 1e3, 0.0},
                                         PlacedCase{1e3, 1e3, 0.0}, PlacedCase{1e-3, 0.0, 0.0},
                                         PlacedCase{1e3, 0.0, 0.0}, PlacedCase{0.1, 1e4, 0.0},
                                         PlacedCase{1e-3, 1e3, 0.05}, PlacedCase{1e3, 1e3, 0.05},
                                         PlacedCase{0.1, 1e4, 0.05}),
                         [](const auto& given) {
                           return "Micrometres" +
                                  std::to_string(std::lround(1e6 * given.param.scale)) + "_At" +
                                  std::to_string(std::lround(given.param.distance_m)) + "m_" +
                                  (given.param.radius == 0.0 ? "Point" : "Sphere");
                         });

}  // namespace
}  // namespace palpate
