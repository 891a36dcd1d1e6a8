#include "haptics/proxy/god_object.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::OwnedWorld;
using test::Random;
using test::Soup;

constexpr double kRelativeAccuracy = 1e-9;  // required by the specification; of the scene's size

// A proxy with positions in the scene frame of its world.
class SceneProxy {
 public:
  explicit SceneProxy(const OwnedWorld& world, double radius_m = 0.0, const Accuracy& accuracy = {})
      : world_(world.world()),
        god_object_(
            test::made(GodObject::create(world_, {.radius_m = radius_m, .accuracy = accuracy}))) {}

  void place(const Vec3& p_scene) { god_object_.place(world_.to_solver(p_scene)); }
  ProxyState move_to(const Vec3& p_scene) {
    ProxyState state = god_object_.move_to(world_.to_solver(p_scene));
    state.proxy = world_.to_scene(state.proxy);
    return state;
  }
  double size() const { return world_.size_m; }

 private:
  const ContactWorld& world_;
  GodObject god_object_;
};

Soup square_plane() {
  Soup soup;
  soup.add_quad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0});
  return soup;
}

// Two half planes that meet along x, with the solid below them; the angle is measured in the solid.
Soup wedge(double solid_angle_rad) {
  const double half = 0.5 * solid_angle_rad;
  const Vec3 right(0.0, std::sin(half), -std::cos(half));
  const Vec3 left(0.0, -std::sin(half), -std::cos(half));
  const Vec3 x = Vec3::UnitX();
  Soup soup;
  soup.add_quad(-x, -x + right, x + right, x);
  soup.add_quad(-x, x, x + left, -x + left);
  return soup;
}

class GodObjectOfRadius : public testing::TestWithParam<double> {};

TEST_P(GodObjectOfRadius, ProjectsOnAPlaneInRandomPoses) {
  const double radius = GetParam();
  Random random(11);
  for (int trial = 0; trial < 50; ++trial) {
    const RigidTransform pose = random.pose(10.0);
    const OwnedWorld world(square_plane(), pose, radius);
    SceneProxy proxy(world, radius);
    proxy.place(pose.point({0.0, 0.0, radius + 0.3}));
    for (int step = 0; step < 50; ++step) {
      const Vec3 goal = random.in_box(0.5);
      const Vec3 expected(goal.x(), goal.y(), std::max(goal.z(), radius));
      const ProxyState state = proxy.move_to(pose.point(goal));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size());
      ASSERT_EQ(state.in_contact, goal.z() < radius);
      ASSERT_FALSE(state.capped);
    }
  }
}

TEST_P(GodObjectOfRadius, FollowsTheOutsideOfABoxInRandomPoses) {
  const double radius = GetParam();
  Random random(12);
  const Vec3 half(0.5, 0.4, 0.3);
  for (int trial = 0; trial < 30; ++trial) {
    const RigidTransform pose = random.pose(10.0);
    const OwnedWorld world(box_soup(half), pose, radius);
    SceneProxy proxy(world, radius);
    // A proxy that moves from far outside towards a face ends on that face, over the goal.
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 goal = 0.9 * random.in_box(1.0).cwiseProduct(half);
      Vec3 start = goal;
      start[axis] = 2.0;
      goal[axis] = random.uniform(-0.2, 0.29);
      proxy.place(pose.point(start));
      const ProxyState state = proxy.move_to(pose.point(goal));
      Vec3 expected = goal;
      expected[axis] = half[axis] + radius;
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size());
      ASSERT_EQ(state.active_planes, 1);
    }
  }
}

TEST_P(GodObjectOfRadius, StaysInsideABoxItStartedIn) {
  const double radius = GetParam();
  Random random(13);
  const Vec3 half(0.5, 0.4, 0.3);
  for (int trial = 0; trial < 30; ++trial) {
    const RigidTransform pose = random.pose(1000.0);
    const OwnedWorld world(box_soup(half), pose, radius);
    SceneProxy proxy(world, radius);
    proxy.place(pose.point(Vec3::Zero()));
    for (int step = 0; step < 50; ++step) {
      const Vec3 goal = random.in_box(1.5);
      const Vec3 room = half - Vec3::Constant(radius);
      const Vec3 expected = goal.cwiseMin(room).cwiseMax(-room);
      const ProxyState state = proxy.move_to(pose.point(goal));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size())
          << "goal " << goal.transpose();
    }
  }
}

// Each tick has one step. The face that stops the step does not hold the proxy yet. The next tick
// must know this face, or the same face would stop it again.
TEST_P(GodObjectOfRadius, KeepsTheFacesThatACappedTickHasMet) {
  const double radius = GetParam();
  constexpr int kMostTicks = 10;
  Accuracy one_step;
  one_step.iterations = 1;
  Random random(19);
  const Vec3 half(0.5, 0.4, 0.3);
  for (int trial = 0; trial < 100; ++trial) {
    const RigidTransform pose = random.pose(10.0);
    const OwnedWorld world(box_soup(half), pose, radius);
    SceneProxy proxy(world, radius, one_step);
    proxy.place(pose.point(Vec3::Zero()));
    const Vec3 goal = (2.0 * half).cwiseProduct(random.in_box(1.0));
    ProxyState state;
    int ticks = 0;
    do {
      state = proxy.move_to(pose.point(goal));
      ++ticks;
    } while (state.capped && ticks < kMostTicks);
    const Vec3 room = half - Vec3::Constant(radius);
    const Vec3 expected = goal.cwiseMin(room).cwiseMax(-room);
    ASSERT_FALSE(state.capped) << "goal " << goal.transpose();
    ASSERT_LE((state.proxy - pose.point(expected)).norm(), kRelativeAccuracy * proxy.size());
  }
}

TEST_P(GodObjectOfRadius, SolvesConcaveWedgesOfAnyAngleInOneTick) {
  const double radius = GetParam();
  Random random(14);
  for (const double opening_deg : {10.0, 60.0, 90.0, 120.0, 179.0, 179.9}) {
    const double solid = (360.0 - opening_deg) * std::numbers::pi / 180.0;
    const double half = 0.5 * opening_deg * std::numbers::pi / 180.0;
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(wedge(solid), pose, radius);
    SceneProxy proxy(world, radius);
    for (int step = 0; step < 40; ++step) {
      proxy.place(pose.point({0.0, 0.0, radius / std::sin(half) + 0.2}));
      const Vec3 goal(random.uniform(-0.5, 0.5), 0.0, random.uniform(-0.4, -0.1));
      const ProxyState state = proxy.move_to(pose.point(goal));
      const Vec3 expected(goal.x(), 0.0, radius / std::sin(half));
      ASSERT_LE((state.proxy - pose.point(expected)).norm(),
                1e-8 / std::sin(half) / std::sin(solid / 2) * proxy.size())
          << opening_deg;
      ASSERT_EQ(state.active_planes, 2);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PointAndSphere, GodObjectOfRadius, testing::Values(0.0, 0.05));

// For goals outside the box but nearer than the radius, the proxy rests on the rounded offset of
// the nearest edge or vertex, straight out from it, after one tick.
TEST(GodObject, RollsOverEdgesAndVerticesToTheExactPoint) {
  Random random(18);
  const double radius = 0.05;
  const Vec3 half(0.5, 0.4, 0.3);
  for (int trial = 0; trial < 200; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(box_soup(half), pose, radius);
    SceneProxy proxy(world, radius);
    proxy.place(pose.point({0.5 * random.uniform(-1, 1), 0.4 * random.uniform(-1, 1), 1.0}));
    proxy.move_to(pose.point({0.0, 0.0, 0.32}));
    for (int step = 0; step < 20; ++step) {
      const bool at_vertex = random.index(2) == 0;
      const Vec3 corner(half.x(), at_vertex ? half.y() : random.uniform(-0.3, 0.3), half.z());
      Vec3 out = random.unit_vector().cwiseAbs() + Vec3::Constant(0.05);
      if (!at_vertex) out.y() = 0.0;
      out.normalize();
      // If the goal is nearer than a third of the radius, the path along the offset surface takes
      // more than one tick.
      const Vec3 goal = corner + random.uniform(0.35, 0.95) * radius * out;
      const ProxyState state = proxy.move_to(pose.point(goal));
      ASSERT_LE((state.proxy - pose.point(corner + radius * out)).norm(),
                kRelativeAccuracy * proxy.size())
          << "trial " << trial << " step " << step << " iterations " << state.iterations;
      ASSERT_FALSE(state.capped);
    }
  }
}

// The face beyond a convex edge is known before it is touched, so that the proxy needs only a slide
// and a step down to that face, for deep goals and for goals next to the surface.
TEST(GodObject, ContinuesOverTheNextFaceOfAConvexEdge) {
  Random random(61);
  for (int trial = 0; trial < 300; ++trial) {
    const double half = random.uniform(0.9, 1.55);
    const RigidTransform pose = random.pose(1.0);
    const Vec3 left(0.0, -std::sin(half), -std::cos(half));
    const Vec3 right(0.0, std::sin(half), -std::cos(half));
    Soup ridge;  // one triangle on each side
    ridge.add(-2.0 * Vec3::UnitX(), 2.0 * left, 2.0 * Vec3::UnitX());
    ridge.add(-2.0 * Vec3::UnitX(), 2.0 * Vec3::UnitX(), 2.0 * right);
    const OwnedWorld world(ridge, pose);
    SceneProxy proxy(world);
    const auto over = [&](const Vec3& down, double along, double x) {
      return Vec3(along * down + x * Vec3::UnitX());
    };
    const auto below = [&](const Vec3& down, double depth) {
      const Vec3 out(0.0, down.y() < 0.0 ? -std::cos(half) : std::cos(half), std::sin(half));
      return Vec3(-depth * out);
    };
    // This limit keeps each goal under its own face, and the right goal beyond the end of the left
    // face.
    const double most = 0.5 * std::min(1.0, -1.0 / std::tan(2.0 * half));
    const double along_left = random.uniform(0.05, 0.5);
    const double along_right = random.uniform(0.05, 0.5);
    const Vec3 on_left = over(left, along_left, random.uniform(-0.5, 0.5));
    const Vec3 on_right = over(right, along_right, random.uniform(-0.5, 0.5));
    const double depth = std::pow(10.0, random.uniform(-6.0, -0.5));
    proxy.place(pose.point(on_left - below(left, 0.1)));
    proxy.move_to(pose.point(on_left + below(left, std::min(depth, most * along_left))));
    const ProxyState state =
        proxy.move_to(pose.point(on_right + below(right, std::min(depth, most * along_right))));
    ASSERT_LE((state.proxy - pose.point(on_right)).norm(), kRelativeAccuracy * proxy.size())
        << "ridge " << trial;
    ASSERT_FALSE(state.capped);
    ASSERT_EQ(state.iterations, 2) << "ridge " << trial;
  }
}

TEST(GodObject, StaysOnItsFaceUntilTheProjectionLeavesIt) {
  const OwnedWorld world(box_soup(Vec3::Constant(0.5)));
  SceneProxy proxy(world);
  proxy.place({0.0, 0.0, 1.0});
  for (double x = 0.0; x < 0.5; x += 0.01) {
    const Vec3 goal(x, 0.0, 0.5 - 0.8 * x);  // nearer to the side wall towards the end
    const ProxyState state = proxy.move_to(goal);
    ASSERT_NEAR(state.proxy.z(), 0.5, 1e-9);
    ASSERT_NEAR(state.proxy.x(), x, 1e-9);
  }
  const ProxyState over = proxy.move_to({0.51, 0.0, 0.1});
  EXPECT_FALSE(over.in_contact);
  EXPECT_EQ(over.proxy, Vec3(0.51, 0.0, 0.1));
}

TEST(GodObject, NeverIncreasesTheDistanceToTheGoal) {
  Random random(15);
  const OwnedWorld world(box_soup({0.5, 0.4, 0.3}));
  for (const double radius : {0.0, 0.05}) {
    const OwnedWorld swept(box_soup({0.5, 0.4, 0.3}), {}, radius);
    SceneProxy proxy(swept, radius);
    proxy.place({0.0, 0.0, 1.0});
    Vec3 at(0.0, 0.0, 1.0);
    for (int step = 0; step < 20000; ++step) {
      const Vec3 goal = random.in_box(0.8);
      const ProxyState state = proxy.move_to(goal);
      ASSERT_LE((state.proxy - goal).norm(), (at - goal).norm() * (1 + 1e-14));
      at = state.proxy;
    }
  }
}

TEST(GodObject, AveragesTheNormalsOfSeveralPlanes) {
  const OwnedWorld world(box_soup(Vec3::Constant(0.5)));
  SceneProxy proxy(world);
  proxy.place(Vec3::Zero());
  const ProxyState state = proxy.move_to({1.0, 1.0, 0.0});
  EXPECT_EQ(state.active_planes, 2);
  EXPECT_LE((state.normal - Vec3(-1, -1, 0).normalized()).norm(), 1e-12);
}

TEST(GodObject, LiftsAStartExactlyOnTheSurfaceToTheFront) {
  Random random(16);
  const OwnedWorld world(box_soup(Vec3::Constant(0.5)));
  for (const Vec3& start : {Vec3(0.1, 0.2, 0.5), Vec3(0.5, 0.1, 0.5), Vec3(0.5, 0.5, 0.5)}) {
    SceneProxy proxy(world);
    proxy.place(start);
    for (int step = 0; step < 100; ++step) {
      const ProxyState state = proxy.move_to(start + random.in_box(0.1));
      ASSERT_GE(state.proxy.cwiseAbs().maxCoeff(), 0.5);
    }
  }
}

// Nothing can be touched far outside, at any speed of the proxy.
TEST(GodObject, IsFreeBeyondTheBoundsOfTheWorld) {
  for (const double radius : {0.0, 0.05}) {
    const OwnedWorld world(box_soup(Vec3::Constant(0.5)), {}, radius);
    SceneProxy proxy(world, radius);
    proxy.place({1.0, 0.013, 0.021});
    for (const double x : {1.4, 1.9, 2.7, 3.6, 4.5, 3.0, 1.2}) {
      const ProxyState state = proxy.move_to({x, 0.013, 0.021});
      EXPECT_FALSE(state.in_contact) << x;
      EXPECT_EQ(state.proxy, Vec3(x, 0.013, 0.021));
    }
  }
}

// With two sensors, the solver works in a plane.
TEST(GodObject, KeepsToThePlaneOfMotion) {
  Random random(17);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(box_soup({0.5, 0.4, 0.3}), pose);
    auto god_object = test::made(GodObject::create(world.world(), {}));
    const Vec3 plane_normal = pose.direction(Vec3::UnitZ());
    const double height = random.uniform(-0.29, 0.29);
    const auto solver = [&](const Vec3& p) { return world.world().to_solver(pose.point(p)); };
    god_object.place(solver({0.0, 0.0, height}));
    for (int step = 0; step < 50; ++step) {
      Vec3 goal = random.in_box(1.0);
      goal.z() = height;
      const ProxyState state = god_object.move_to(solver(goal), plane_normal);
      const Vec3 expected(std::clamp(goal.x(), -0.5, 0.5), std::clamp(goal.y(), -0.4, 0.4), height);
      ASSERT_LE((state.proxy - solver(expected)).norm(), 1e-9);
      ASSERT_LE(std::abs(state.normal.dot(plane_normal)), 1e-12);
    }
  }
}

// The points where the edges of a box around the origin cross a plane through the origin.
std::vector<Vec3> corners_in_plane(const Vec3& half_extent, const Vec3& normal) {
  std::vector<Vec3> corners;
  for (int axis = 0; axis < 3; ++axis) {
    if (normal[axis] == 0.0) continue;
    for (const double u : {-1.0, 1.0}) {
      for (const double v : {-1.0, 1.0}) {
        Vec3 p = Vec3::Zero();
        p[(axis + 1) % 3] = u * half_extent[(axis + 1) % 3];
        p[(axis + 2) % 3] = v * half_extent[(axis + 2) % 3];
        p[axis] = -normal.dot(p) / normal[axis];
        if (std::abs(p[axis]) <= half_extent[axis]) corners.push_back(p);
      }
    }
  }
  return corners;
}

// Faces make any angle with the plane of motion, and the rounding of the goal is much larger than
// that of the faces.
TEST(GodObject, RestsInThePlaneOfMotionHoweverFarTheGoalIs) {
  constexpr double kSize = 1.0;
  constexpr double kLeastGain = 1e-9 * kSize;
  const Vec3 half_extent(0.5, 0.4, 0.3);
  Random random(23);
  for (int trial = 0; trial < 200; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(box_soup(half_extent), pose);
    const auto solver = [&](const Vec3& p) { return world.world().to_solver(pose.point(p)); };
    const Vec3 normal = random.unit_vector();
    const Vec3 across = normal.cross(random.unit_vector()).normalized();
    const std::vector<Vec3> corners = corners_in_plane(half_extent, normal);
    auto god_object = test::made(GodObject::create(world.world(), {}));
    god_object.place(solver(Vec3::Zero()));
    for (int tick = 0; tick < 20; ++tick) {
      const double angle_rad = random.uniform(0.0, 2 * std::numbers::pi);
      const double far_m = std::pow(10.0, random.uniform(0.0, 6.0)) * kSize;
      const Vec3 direction =
          std::cos(angle_rad) * across + std::sin(angle_rad) * normal.cross(across);
      const Vec3 goal = solver(far_m * direction);
      const ProxyState state = god_object.move_to(goal, pose.direction(normal));
      ASSERT_FALSE(state.capped) << far_m;
      const double lag_m = (state.proxy - goal).norm();
      for (const Vec3& corner : corners) {
        ASSERT_LE(lag_m, (solver(corner) - goal).norm() + kLeastGain) << far_m;
      }
    }
  }
}

// A bowl of 9 to 256 squares with a width of 1 and a depth from almost 0 to 1 %.
Soup shallow_bowl(Random& random) {
  const int n = 3 + static_cast<int>(random.index(14));
  const double depth = 1e-6 * std::pow(1e4, random.uniform(0.0, 1.0));
  const Vec3 middle = 0.2 * random.unit_vector();
  Soup soup;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      Vec3 p(i / static_cast<double>(n) - 0.5, j / static_cast<double>(n) - 0.5, 0.0);
      p.z() = depth * (p - middle).head<2>().squaredNorm();
      soup.positions.push_back(p);
    }
  }
  const auto stride = static_cast<std::uint32_t>(n + 1);
  for (std::uint32_t a = 0; a < stride * (stride - 1); ++a) {
    if (a % stride == stride - 1) continue;
    const std::uint32_t b = a + stride;
    if (random.index(2)) {
      soup.triangles.insert(soup.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
    } else {
      soup.triangles.insert(soup.triangles.end(), {{a, b, a + 1}, {b, b + 1, a + 1}});
    }
  }
  return soup;
}

// A point that has descended over a face as far as it may is blocked by the edge of the next face
// if rounding makes that edge higher, as if it were in a groove.
TEST(GodObject, IsNotStuckAtCreasesThatAreAlmostFlat) {
  Random random(31);
  for (int trial = 0; trial < 1000; ++trial) {
    const Soup soup = shallow_bowl(random);
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(soup, pose);
    const auto solver = [&](const Vec3& p) { return world.world().to_solver(pose.point(p)); };
    auto god_object = test::made(GodObject::create(world.world(), {}));
    Vec3 from(0.0, 0.0, 0.1);
    god_object.place(solver(from));
    for (int n = 0; n < 10; ++n) {
      const double depth = random.uniform(0.001, 0.3);
      const double y = random.uniform(-0.4, 0.4);
      Vec3 goal(random.uniform(-0.4, 0.4), y, -depth);
      if (random.index(3) == 0) {
        goal = soup.positions[random.index(soup.positions.size())];
        goal.z() -= random.uniform(0.0, 0.1);
      }
      const auto steps = static_cast<int>(1 + random.index(30));
      ProxyState state;
      for (int step = 1; step <= steps; ++step) {
        state =
            god_object.move_to(solver(from + step / static_cast<double>(steps) * (goal - from)));
      }
      for (int tick = 0; state.capped && tick < 10; ++tick) {
        state = god_object.move_to(solver(goal));
      }
      ASSERT_FALSE(state.capped) << "bowl " << trial << ", goal " << n;
      from = goal;
    }
  }
}

// A groove along x between two flat banks, 1 long and 0.3 deep.
Soup groove(double half_width) {
  Soup soup;
  for (const double side : {-1.0, 1.0}) {
    const double y = side * half_width;
    soup.add_quad({-0.5, y, 0.3}, {0.5, y, 0.3}, {0.5, 0.0, 0.0}, {-0.5, 0.0, 0.0});
    soup.add_quad({-0.5, y, 0.3}, {0.5, y, 0.3}, {0.5, 0.5 * side, 0.3}, {-0.5, 0.5 * side, 0.3});
  }
  return soup;
}

// The walls may be nearly parallel. The solver must not mistake the walls that hold the point for
// rounding, and rounding must not make the point creep.
TEST(GodObject, RestsInGroovesHoweverNarrowAndKeepsItsPosition) {
  Random random(47);
  for (int trial = 0; trial < 400; ++trial) {
    const double half_width = 1e-8 * std::pow(3e7, random.uniform(0.0, 1.0));
    const RigidTransform pose = random.pose(1.0);
    const OwnedWorld world(groove(half_width), pose);
    auto god_object = test::made(GodObject::create(world.world(), {}));
    FrictionCone cone{random.uniform(0.1, 1.0), 0.0};
    cone.dynamic_friction = cone.static_friction * random.uniform(0.5, 1.0);
    test::SameCone same(cone);
    const FrictionSource friction{same};
    const bool has_friction = random.index(3) == 0;
    std::optional<Vec3> plane;  // along the groove
    if (!has_friction && random.index(2)) plane = pose.direction(Vec3::UnitY());
    Vec3 from(random.uniform(-0.4, 0.4), 0.0, 0.5);
    const auto move_to = [&](const Vec3& p) {
      const Vec3 goal = world.world().to_solver(pose.point(p));
      return has_friction ? god_object.move_with_friction(goal, plane, friction)
                          : god_object.move_to(goal, plane);
    };
    god_object.place(world.world().to_solver(pose.point(from)));
    for (int n = 0; n < 10; ++n) {
      const double aside = plane ? 0.0 : random.uniform(-0.1, 0.1);
      const Vec3 goal(random.uniform(-0.4, 0.4), aside * half_width,
                      -0.3 * std::pow(300.0, -random.uniform(0.0, 1.0)));
      ProxyState state;
      for (int step = 1; step <= 20; ++step) state = move_to(from + step / 20.0 * (goal - from));
      for (int tick = 0; tick < 5; ++tick) state = move_to(goal);
      const Vec3 rest = state.proxy;
      for (int tick = 0; tick < 25; ++tick) {
        state = move_to(goal);
        ASSERT_FALSE(state.capped) << "groove " << trial << ", half as wide as " << half_width;
        ASSERT_EQ(state.proxy, rest) << "groove " << trial << ", half as wide as " << half_width;
      }
      from = goal;
    }
  }
}

}  // namespace
}  // namespace palpate
