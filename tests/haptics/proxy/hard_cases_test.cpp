// The hard cases of god-object rendering with difficult device motions: exactly onto objects,
// across them, over a ridge, through a plate, and to and fro. JudgedProxy judges each tick.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/hard_case_proxy.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
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

constexpr double kStiffness_N_per_m = 1000.0;

struct NamedSoup {
  std::string name;
  Soup soup;
};

// Closed surfaces around the origin: the paper's objects and some simple or round ones.
std::vector<NamedSoup> closed_soups() {
  std::vector<NamedSoup> soups;
  for (const PaperObject& object : paper_objects()) {
    soups.push_back({object.name, test::paper_object_soup(object)});
  }
  soups.push_back({"box", test::box_soup({0.1, 0.08, 0.06})});
  soups.push_back({"sphere", test::soup_of(icosphere(2, 0.1))});
  soups.push_back({"torus", test::soup_of(torus(0.1, 0.03, 1))});
  return soups;
}

Vec3 normal_of(const Soup& soup, const Triangle& t) {
  const Vec3& a = soup.positions[t[0]];
  return (soup.positions[t[1]] - a).cross(soup.positions[t[2]] - a).normalized();
}

// ---- 10 exactly on a face, an edge, a vertex, the proxy ----------------------------------------

class HardCase10_DeviceExactlyOnTheSurface : public testing::TestWithParam<double> {};

// A point of the surface that is exact on a lattice, and the mean of the normals there.
struct ExactAim {
  Vec3 point;
  Vec3 outward;
};

ExactAim random_aim(const Soup& soup, Random& random) {
  const Triangle& t = soup.triangles[random.index(soup.triangles.size())];
  const Vec3& a = soup.positions[t[0]];
  const Vec3 ab = soup.positions[t[1]] - a;
  const Vec3 ac = soup.positions[t[2]] - a;
  const std::uint64_t kind = random.index(3);  // vertex, edge, face
  const double along = kind == 0 ? 0.0 : 0x1p-8 * static_cast<double>(1 + random.index(127));
  const double aside = kind < 2 ? 0.0 : 0x1p-8 * static_cast<double>(1 + random.index(127));
  ExactAim aim{a + along * ab + aside * ac, Vec3::Zero()};
  std::vector<Vec3> normals;
  for (const Triangle& other : soup.triangles) {
    const TriangleGeometry g{soup.positions[other[0]], soup.positions[other[1]],
                             soup.positions[other[2]], normal_of(soup, other)};
    if (closest_point_on_triangle(g, aim.point).distance > 0x1p-30) continue;
    // The two triangles of a wall that was rounded to the lattice count once.
    const auto same = [&](const Vec3& n) { return n.dot(g.normal) > 1 - 1e-6; };
    if (std::none_of(normals.begin(), normals.end(), same)) normals.push_back(g.normal);
  }
  for (const Vec3& n : normals) aim.outward += n;
  aim.outward.normalize();
  return aim;
}

TEST_P(HardCase10_DeviceExactlyOnTheSurface, KeepsItsSideAndEndsWithinAStandOff) {
  const double radius = GetParam();
  Random random(201);
  for (const NamedSoup& shape : closed_soups()) {
    for (int n = 0; n < trials(20); ++n) {
      const Soup soup = on_lattice(posed(shape.soup, random.pose(0.5)));
      const OwnedWorld world(soup, {}, radius);
      JudgedProxy proxy(world, radius);
      for (int trial = 0; trial < 50; ++trial) {
        const ExactAim aim = random_aim(soup, random);
        const Vec3 start = aim.point + (2 * radius + 5e-3) * aim.outward;
        // A sphere does not fit beside a wall that stands on this one.
        const Vec3 start_solver = world.world().to_solver(start);
        if (world.index().closest_point(start_solver, 1.01 * radius)) continue;
        proxy.place(start);
        ProxyState state = proxy.move_to(aim.point);
        if (radius == 0.0) {
          // Walls meet at 36 deg or more, so that a corner is within 1/sin(18 deg) stand-offs.
          ASSERT_LE((state.proxy - aim.point).norm(), 4 * proxy.scale().stand_off_m)
              << shape.name << " trial " << trial;
        }
        for (int hold = 0; hold < 3; ++hold) proxy.move_to(aim.point);
        // A goal exactly at the proxy leaves the proxy in place bit for bit, without contact.
        const Vec3 at = proxy.proxy_solver();
        state = proxy.move_to_solver(at);
        ASSERT_EQ(proxy.proxy_solver(), at);
        ASSERT_FALSE(state.in_contact);
        proxy.move_to(start);
        ASSERT_FALSE(proxy.move_to(start).in_contact) << shape.name << " trial " << trial;
        ASSERT_EQ(proxy.verdict(), "") << shape.name << " pose " << n << " trial " << trial;
      }
    }
  }
}

TEST(HardCase10_DeviceExactlyOnTheSurfaceAtTheStart, IsLiftedToTheFrontAndKeptThere) {
  Random random(202);
  for (const NamedSoup& shape : closed_soups()) {
    for (int n = 0; n < trials(20); ++n) {
      const Soup soup = on_lattice(posed(shape.soup, random.pose(0.5)));
      const OwnedWorld world(soup);
      JudgedProxy proxy(world);
      for (int trial = 0; trial < 50; ++trial) {
        const ExactAim aim = random_aim(soup, random);
        proxy.place(aim.point);
        const Vec3 lift = proxy.proxy_scene() - aim.point;
        ASSERT_GT(lift.dot(aim.outward), 0.0) << shape.name << " trial " << trial;
        for (const double depth : {1e-9, 1e-6, 1e-5}) {
          const ProxyState state = proxy.move_to(aim.point - depth * aim.outward);
          ASSERT_TRUE(state.in_contact) << shape.name << " trial " << trial << " depth " << depth;
        }
        ASSERT_EQ(proxy.verdict(), "") << shape.name << " pose " << n << " trial " << trial;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase10_DeviceExactlyOnTheSurface, testing::Values(0.0, 2e-3),
                         radius_name);

// ---- 11 jumps ----------------------------------------------------------------------------------

class HardCase11_Teleport : public testing::TestWithParam<double> {};

// Jumps between arbitrary positions in one tick: nearby, across the object, and a billion sizes
// away.
TEST_P(HardCase11_Teleport, CrossesNothing) {
  const double radius = GetParam();
  Random random(203);
  for (const NamedSoup& shape : closed_soups()) {
    for (int n = 0; n < trials(10); ++n) {
      const RigidTransform pose = random.pose(1.0);
      const OwnedWorld world(posed(shape.soup, pose), {}, radius);
      JudgedProxy proxy(world, radius);
      proxy.place(pose.point({0.0, 0.0, 0.3}));
      for (int tick = 0; tick < 300; ++tick) {
        const double reach = random.index(10) == 0 ? std::pow(10.0, random.uniform(-1.0, 9.0))
                                                   : random.uniform(0.0, 0.3);
        const Vec3 goal = reach * random.unit_vector();
        proxy.move_to(pose.point(goal));
        ASSERT_EQ(proxy.verdict(), "") << shape.name << " pose " << n << " tick " << tick;
      }
      // Far outside, the proxy is free again and reaches the goal bit for bit.
      const Vec3 out = pose.point({3.0, 2.0, 5.0});
      for (int tick = 0; tick < 50; ++tick) proxy.move_to(out);
      ASSERT_EQ(proxy.verdict(), "") << shape.name << " pose " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase11_Teleport, testing::Values(0.0, 2e-3), radius_name);

// ---- 12 sweeps over a ridge --------------------------------------------------------------------

class HardCase12_RidgeSweep : public testing::TestWithParam<double> {
 protected:
  static HapticSettings undamped(double radius_m) {
    HapticSettings settings;
    settings.god_object.radius_m = radius_m;
    settings.coupling = {kStiffness_N_per_m, 0.0};
    settings.force = ForceMode::kFull;
    settings.a4.enabled = false;
    return settings;
  }
};

// The largest step of the force at a ridge of exterior angle delta, where the proxy changes faces.
// A force K d turns by delta and keeps the component K d cos(delta), which is a step of K d
// sin(delta) <= 2 K d sin(delta/2). The device moves by dx in the same tick. This motion changes
// the force on either face by at most K |dx|, and the depth at the ridge may exceed d by |dx|. A
// loss of contact at the ridge is a step of K d. The bound covers such a step for delta >= 60 deg,
// and contact is not lost at a ridge below 90 deg.
double force_step_bound_N(double depth_m, double dx_m, double exterior_rad) {
  return kStiffness_N_per_m * (2 * (depth_m + dx_m) * std::sin(0.5 * exterior_rad) + dx_m);
}

struct ForceWatch {
  explicit ForceWatch(double exterior) : exterior_rad(exterior) {}
  // Records the largest step of the force relative to its bound.
  void see(const TickRecord& now) {
    const double dx_m = (vec3(now.goal_scene_m) - vec3(last.goal_scene_m)).norm();
    const double bound_N = force_step_bound_N(
        (vec3(last.proxy_scene_m) - vec3(last.goal_scene_m)).norm(), dx_m, exterior_rad);
    const double step_N = (vec3(now.full_force_device_N) - vec3(last.full_force_device_N)).norm();
    if (bound_N > 0.0) worst = std::max(worst, step_N / bound_N);
    last = now;
  }
  double exterior_rad;
  double worst = 0.0;
  TickRecord last;
};

// Tolerance of the force. The height of the proxy over the surface varies by a stand-off, which is
// much less than 1e-6 of a depth.
constexpr double kForceRoundoff = 1e-6;

TEST_P(HardCase12_RidgeSweep, StepsTheForceByNoMoreThanTheRidge) {
  const double radius = GetParam();
  const int poses = 10;
  const int sweeps = trials(1000);
  Random random(204);
  std::uint64_t crossings = 0;
  for (const double exterior_deg : {1.0, 10.0, 45.0, 90.0, 135.0}) {
    const double solid_rad = (180.0 - exterior_deg) * kDeg;
    for (int n = 0; n < poses; ++n) {
      const RigidTransform pose = random.pose(1.0);
      const OwnedWorld world(posed(test::wedge_soup(solid_rad), pose), {}, radius);
      auto loop = test::made(HapticLoop::create(
          world.world(), ActuationModel::from_counts(3, 3).value(), undamped(radius)));
      ForceWatch watch(exterior_deg * kDeg);
      watch.last = loop.tick(pose.point({0.0, 0.0, radius + 0.01}), kTick_s);
      double y = 0.0;
      double side = 1.0;
      for (int sweep = 0; sweep < sweeps; ++sweep) {
        const double speed = random.uniform(1e-4, 5e-4);
        const double top = radius - random.uniform(1e-4, 2e-3);
        for (; side * y < 2e-3; y += side * speed) {
          watch.see(loop.tick(pose.point({0.1 * std::sin(1e-3 * sweep), y, top}), kTick_s));
        }
        crossings += watch.last.contact;
        side = -side;
      }
      ASSERT_LE(watch.worst, 1 + kForceRoundoff) << exterior_deg << " deg, pose " << n;
    }
  }
  // Both radii together make 1e5 sweeps. Only sweeps that end in contact count.
  EXPECT_GT(crossings, static_cast<std::uint64_t>(sweeps) * poses);
}

// The same test round the paper's objects: the hand moves along each wall at constant depth, beyond
// the end of the wall as is necessary at a corner, and then along the next wall.
TEST_P(HardCase12_RidgeSweep, HoldsRoundThePapersObjects) {
  const double radius = GetParam();
  const double depth = 1e-3;
  Random random(205);
  for (const PaperObject& object : paper_objects()) {
    const Contour& contour = object.contour_m;
    std::vector<Vec3> route;
    double sharpest = 60 * kDeg;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const auto corner = [&](std::size_t k) {
        const Point2& c = contour[k % contour.size()];
        return Vec3(c.x(), c.y(), 0.0);
      };
      const Vec3 along = (corner(i + 1) - corner(i)).normalized();
      const Vec3 next = (corner(i + 2) - corner(i + 1)).normalized();
      const Vec3 normal = along.cross(Vec3::UnitZ());
      route.push_back(corner(i) + 2e-3 * along + (radius - depth) * normal);
      route.push_back(corner(i + 1) + (radius + 2e-3) * along + (radius - depth) * normal);
      const double exterior = std::acos(std::clamp(along.dot(next), -1.0, 1.0));
      if (along.cross(next).z() > 0.0) sharpest = std::max(sharpest, exterior);
    }
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::paper_object_soup(object), pose), {}, radius);
    auto loop = test::made(HapticLoop::create(
        world.world(), ActuationModel::from_counts(3, 3).value(), undamped(radius)));
    JudgedProxy proxy(world, radius);
    ForceWatch watch(sharpest);
    Vec3 at = route[0] + (0.01 + depth) * (route[1] - route[0]).normalized().cross(Vec3::UnitZ());
    proxy.place(pose.point(at));
    watch.last = loop.tick(pose.point(at), kTick_s);
    for (const Vec3& to : route) {
      const int steps = static_cast<int>(std::ceil((to - at).norm() / 1e-4));
      const Vec3 step = (to - at) / steps;
      for (int k = 0; k < steps; ++k) {
        at += step;
        watch.see(loop.tick(pose.point(at), kTick_s));
        proxy.move_to(pose.point(at));
      }
      ASSERT_EQ(proxy.verdict(), "") << object.name;
      ASSERT_LE(watch.worst, 1 + kForceRoundoff) << object.name << " at " << at.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase12_RidgeSweep, testing::Values(0.0, 2e-3), radius_name);

// ---- 13 through the middle of a thin plate -----------------------------------------------------

class HardCase13_MedialAxis : public testing::TestWithParam<double> {};

TEST_P(HardCase13_MedialAxis, KeepsTheProxyOnItsOriginalSide) {
  const double radius = GetParam();
  const Vec3 half(0.1, 0.1, 1e-3);
  Random random(206);
  for (int n = 0; n < trials(100); ++n) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::box_soup(half), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    const double side = n % 2 ? 1.0 : -1.0;
    Vec3 at(0.0, 0.0, side * (radius + 0.01));
    proxy.place(pose.point(at));
    // The hand moves to and fro through the plate and beyond it. The force has no change at the
    // middle.
    for (int tick = 0; tick < 200; ++tick) {
      at += random.in_box(2e-3).cwiseProduct(Vec3(1, 1, 0));
      at.z() = side * 5e-3 * std::cos(0.1 * tick);
      const ProxyState state = proxy.move_to(pose.point(at));
      const Vec3 expected(at.x(), at.y(), side * std::max(side * at.z(), half.z() + radius));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size_m());
    }
    // The proxy reaches the other side only over the rim.
    at.z() = -side * 0.02;
    for (; at.x() < half.x() + 2 * radius + 5e-3; at.x() += 1e-3) {
      const ProxyState state = proxy.move_to(pose.point(at));
      const Vec3 goal = world.world().to_solver(pose.point(at));
      ASSERT_EQ(state.in_contact, proxy.proxy_solver() != goal);
    }
    ASSERT_FALSE(proxy.move_to(pose.point(at)).in_contact);
    at.x() = 0.0;
    at.z() = -side * (half.z() + radius + 0.01);
    proxy.move_to(pose.point(at));
    const ProxyState below = proxy.move_to(pose.point({at.x(), at.y(), 0.0}));
    const Vec3 expected(at.x(), at.y(), -side * (half.z() + radius));
    ASSERT_LE((below.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size_m());
    ASSERT_EQ(proxy.verdict(), "") << "pose " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase13_MedialAxis, testing::Values(0.0, 2e-3), radius_name);

// ---- 14 reversals ------------------------------------------------------------------------------

class HardCase14_Reversal : public testing::TestWithParam<double> {};

// The hand moves to and fro for a million ticks without friction. Whenever the device returns to a
// position, so must the proxy. On a plane one face holds the proxy, in a valley two.
TEST_P(HardCase14_Reversal, DoesNotDriftWithoutFriction) {
  const double radius = GetParam();
  constexpr int kPeriod = 1000;
  Random random(207);
  for (const double opening_deg : {180.0, 120.0}) {
    const double solid_rad = (360.0 - opening_deg) * kDeg;
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(posed(test::wedge_soup(solid_rad), pose), {}, radius);
    JudgedProxy proxy(world, radius);
    const double bottom = radius / std::sin(0.5 * opening_deg * kDeg);
    const Vec3 amplitude(0.02, opening_deg == 180.0 ? 0.02 : 0.0, 0.0);
    proxy.place(pose.point({0.0, 0.0, bottom + 0.01}));
    std::vector<Vec3> first(kPeriod);
    double drift_m = 0.0;
    for (int tick = 0; tick < trials(500) * kPeriod; ++tick) {
      const int phase = tick % kPeriod;
      // The motion is a triangle wave, so that the hand reverses within a tick.
      const double part = std::abs(4.0 * phase / kPeriod - 2.0) - 1.0;
      const Vec3 goal = part * amplitude + Vec3(0.03, 0.0, bottom - 2e-3);
      const Vec3 at = proxy.move_to(pose.point(goal)).proxy;
      if (tick < kPeriod) first[static_cast<std::size_t>(phase)] = at;
      drift_m = std::max(drift_m, (at - first[static_cast<std::size_t>(phase)]).norm());
    }
    ASSERT_EQ(proxy.verdict(), "");
    // The distance of a proxy from a face is between a clearance and a stand-off.
    EXPECT_LE(drift_m, proxy.scale().stand_off_m / std::sin(0.5 * opening_deg * kDeg));
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase14_Reversal, testing::Values(0.0, 5e-3), radius_name);

}  // namespace
}  // namespace palpate
