// Compares Coulomb's friction on the god-object with the law in closed form.

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/haptics/three_axes.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::hand_settings;
using test::kEpsilon;
using test::kStiffness_N_per_m;
using test::kTick_s;
using test::OwnedBodies;
using test::OwnedWorld;
using test::Random;
using test::Soup;
using test::three_axes;
using test::with_friction;

constexpr double kPlaneHalf_m = 0.1;

Soup plane_soup() {
  Soup soup;
  soup.add_quad({-kPlaneHalf_m, -kPlaneHalf_m, 0}, {kPlaneHalf_m, -kPlaneHalf_m, 0},
                {kPlaneHalf_m, kPlaneHalf_m, 0}, {-kPlaneHalf_m, kPlaneHalf_m, 0});
  return soup;
}

// Two planes that meet in a groove along y, each rising at this angle.
Soup groove_soup(double rise_rad) {
  const double x = kPlaneHalf_m * std::cos(rise_rad);
  const double z = kPlaneHalf_m * std::sin(rise_rad);
  Soup soup;
  soup.add_quad({0, -kPlaneHalf_m, 0}, {x, -kPlaneHalf_m, z}, {x, kPlaneHalf_m, z},
                {0, kPlaneHalf_m, 0});
  soup.add_quad({-x, -kPlaneHalf_m, z}, {0, -kPlaneHalf_m, 0}, {0, kPlaneHalf_m, 0},
                {-x, kPlaneHalf_m, z});
  return soup;
}

// A plane with friction in a random pose, and a hand that follows commands in the plane's frame.
class PlaneHand {
 public:
  PlaneHand(const RigidTransform& pose, double mu_s, double mu_k, double damping = 0.0)
      : pose_(pose), world_(plane_soup(), pose) {
    world_.set_effects(with_friction(mu_s, mu_k));
    loop_ = test::made(HapticLoop::create(world_.world(), three_axes(),
                                          hand_settings(kStiffness_N_per_m, damping)));
  }

  const TickRecord& go_to(const Vec3& p_plane) {
    return loop_->tick(pose_.point(p_plane), kTick_s);
  }
  Vec3 proxy() const { return pose_.inverse_point(vec3(last_->proxy_scene_m)); }
  const TickRecord& tick(const Vec3& p_plane) {
    last_ = &go_to(p_plane);
    return *last_;
  }
  Vec3 force() const { return pose_.inverse_direction(vec3(last_->force_device_N)); }
  // The error of positions read back from the scene: the solver's stand-off and rounding in the
  // pose.
  double tolerance_m() const {
    return 4 * SolverScale::of(2 * kPlaneHalf_m, 0.0).stand_off_m +
           64 * kEpsilon * (pose_.translation_m.norm() + kPlaneHalf_m);
  }

 private:
  RigidTransform pose_;
  OwnedWorld world_;
  std::optional<HapticLoop> loop_;
  const TickRecord* last_ = nullptr;
};

// The law in closed form: the proxy's position, and whether it sticks or slides.
struct Law {
  double mu_s, mu_k;
  Vec3 proxy = Vec3::Zero();
  bool slides = false;

  // True if the proxy keeps its place. foot: the goal's projection on the plane.
  bool keeps_place(const Vec3& foot, double depth) {
    const Vec3 lag = proxy - foot;
    constexpr double kSame_m = 1e-13;  // some roundings of its position
    if (lag.norm() <= (slides ? mu_k : mu_s) * depth + kSame_m) {
      slides = slides && lag.norm() >= mu_k * depth - kSame_m;
      return true;
    }
    slides = true;
    proxy = foot + mu_k * depth * lag.normalized();
    return false;
  }
};

TEST(Friction, FollowsTheLawTickByTick) {
  Random random(5101);
  int slides = 0;
  int slides_again = 0;
  int rests = 0;
  for (int run = 0; run < 40; ++run) {
    const double mu_k = random.uniform(0.05, 1.5);
    const double mu_s = mu_k * random.uniform(1.0, 2.0);
    PlaneHand hand(random.pose(1.0), mu_s, mu_k);
    hand.tick({0, 0, 0.002});
    Vec3 goal(0, 0, -0.002);
    ASSERT_EQ(hand.tick(goal).friction, FrictionState::kSticks);
    Law law{mu_s, mu_k};
    Vec3 heading = Vec3::Zero();
    for (int tick = 0; tick < 500; ++tick) {
      if (tick % 20 == 0) heading = 3e-4 * random.unit_vector();
      goal += heading + random.in_box(3e-4);
      goal = goal.cwiseMax(Vec3(-0.05, -0.05, -0.01)).cwiseMin(Vec3(0.05, 0.05, -1e-4));
      const bool slid_before = law.slides;
      const bool keeps = law.keeps_place({goal.x(), goal.y(), 0}, -goal.z());
      const TickRecord& record = hand.tick(goal);
      ASSERT_EQ(record.friction, law.slides ? FrictionState::kSlides : FrictionState::kSticks);
      slides += !keeps;
      slides_again += !keeps && slid_before;
      rests += keeps;
      // The error of a tick may carry over to the next.
      ASSERT_LE((hand.proxy() - law.proxy).norm(), (tick + 1) * (1 + mu_s) * hand.tolerance_m());
      law.proxy = hand.proxy();
      law.proxy.z() = 0.0;
    }
  }
  EXPECT_GT(slides, 1000);
  EXPECT_GT(slides_again, 1000);
  EXPECT_GT(rests, 1000);
}

TEST(Friction, SlidesWithALagOfTheCoefficientTimesTheDepth) {
  Random random(5102);
  for (int run = 0; run < 100; ++run) {
    const double mu = random.uniform(0.05, 2.0);
    const double depth = random.uniform(1e-4, 5e-3);
    PlaneHand hand(random.pose(1.0), mu, mu);
    hand.tick({-0.05, 0, 0.001});
    for (double x = -0.05; x < 0.05; x += 5e-4) hand.tick({x, 0.2 * x, -depth});
    const Vec3 goal(0.05, 0.01, -depth);
    hand.tick(goal);
    const double lag = std::hypot(hand.proxy().x() - goal.x(), hand.proxy().y() - goal.y());
    ASSERT_NEAR(lag, mu * depth, 1e-9);
    ASSERT_LT(hand.proxy().x(), goal.x());
  }
}

TEST(Friction, ForcesKeepTheRatioWithAnyDamping) {
  Random random(5103);
  for (int run = 0; run < 40; ++run) {
    const double mu_k = random.uniform(0.05, 1.0);
    const double mu_s = mu_k * random.uniform(1.0, 1.5);
    PlaneHand hand(random.pose(0.2), mu_s, mu_k, random.uniform(0.0, 3.0));
    hand.tick({0, 0, 0.001});
    Vec3 goal(0, 0, -0.001);
    Vec3 last = Vec3::Zero();
    int slides = 0;
    for (int tick = 0; tick < 400; ++tick) {
      goal += random.in_box(1e-3);
      goal = goal.cwiseMax(Vec3(-0.05, -0.05, -0.003)).cwiseMin(Vec3(0.05, 0.05, -5e-4));
      hand.tick(goal);
      const Vec3 force = hand.force();
      const double side = std::hypot(force.x(), force.y());
      const bool slid = tick > 0 && (hand.proxy() - last).norm() > hand.tolerance_m();
      last = hand.proxy();
      ASSERT_GE(force.z(), 0.0);
      const double rounding = 1e-9 * force.norm();  // of normals in the pose, far above 2^-53
      if (slid) {
        ASSERT_NEAR(side, mu_k * force.z(), rounding);
        ++slides;
      } else if (tick > 0) {
        ASSERT_LE(side, mu_s * force.z() + rounding);
      }
    }
    ASSERT_GT(slides, 20);
  }
}

// A hand at rest with a tremor inside the cone must not move the proxy.
template <typename Tremor>
void expect_no_drift(const OwnedWorld& world, const Vec3& above, const Vec3& pressed, int ticks,
                     Tremor tremor) {
  auto loop = test::made(HapticLoop::create(world.world(), three_axes(), hand_settings()));
  loop.tick(above, kTick_s);
  for (int i = 1; i <= 20; ++i) loop.tick(above + i / 20.0 * (pressed - above), kTick_s);
  const Vec3 rest = vec3(loop.tick(pressed, kTick_s).proxy_scene_m);
  for (int tick = 0; tick < ticks; ++tick) {
    const TickRecord& record = loop.tick(pressed + tremor(), kTick_s);
    ASSERT_EQ(vec3(record.proxy_scene_m), rest) << "tick " << tick;
    ASSERT_EQ(record.faults, kFaultNone);
  }
}

TEST(Friction, DoesNotDriftAtRestInAMillionTicks) {
  Random random(5104);
  OwnedWorld world(plane_soup(), random.pose(0.2));
  world.set_effects(with_friction(0.5, 0.4));
  const RigidTransform pose{world.world().bodies[0].T_solver_body.rotation,
                            world.world().anchor_scene_m};
  expect_no_drift(world, pose.point({0, 0, 0.001}), pose.point({0, 0, -0.002}), 1000000,
                  [&] { return Vec3(0.4e-3 * random.uniform(-1, 1) * random.unit_vector()); });
}

TEST(Friction, DoesNotDriftInAGrooveOrACorner) {
  Random random(5105);
  for (const double rise_deg : {10.0, 45.0, 80.0}) {
    const Soup soup = groove_soup(rise_deg * std::numbers::pi / 180.0);
    OwnedWorld world(soup);
    world.set_effects(with_friction(0.3, 0.3));
    expect_no_drift(world, {0, 0, 0.002}, {0, 0, -0.002}, 20000,
                    [&] { return Vec3(0, 0.5e-3 * random.uniform(-1, 1), 0); });
  }
  Soup corner;  // an inside corner
  corner.add_quad({0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0});
  corner.add_quad({0, 0, 0}, {0, 0.1, 0}, {0, 0.1, 0.1}, {0, 0, 0.1});
  corner.add_quad({0, 0, 0}, {0, 0, 0.1}, {0.1, 0, 0.1}, {0.1, 0, 0});
  OwnedWorld world(corner);
  world.set_effects(with_friction(0.3, 0.3));
  expect_no_drift(world, {0.01, 0.01, 0.01}, {-0.002, -0.002, -0.002}, 20000,
                  [&] { return random.in_box(0.5e-3); });
}

TEST(Friction, DoesNotDriftOnCurvedMeshes) {
  Random random(5106);
  const TriangleMesh mesh = icosphere(4, 0.05);
  OwnedWorld world(Soup{mesh.positions_m, mesh.triangles});
  world.set_effects(with_friction(0.6, 0.5));
  for (int place = 0; place < 20; ++place) {
    const Vec3 outwards = random.unit_vector();
    // At a depth of 2 mm, friction holds at least 1 mm of tremor, on any facet.
    expect_no_drift(world, 0.052 * outwards, 0.048 * outwards, 3000,
                    [&] { return Vec3(0.2e-3 * random.unit_vector()); });
  }
}

TEST(Friction, ReversalsMoveTheLagAcrossTheWholeConeAndBack) {
  for (const double mu : {0.0, 0.3, 10.0}) {
    PlaneHand hand({}, mu, mu);
    const double depth = 1e-3;
    hand.tick({0, 0, 0.001});
    hand.tick({0, 0, -depth});
    const double reach = 0.02;
    for (int cycle = 0; cycle < 50; ++cycle) {
      for (int i = 0; i < 400; ++i) {
        const double x = reach * std::sin(2 * std::numbers::pi * i / 400.0);
        hand.tick({x, 0, -depth});
        ASSERT_LE(std::abs(hand.proxy().x() - x), mu * depth + (1 + mu) * hand.tolerance_m());
        ASSERT_EQ(hand.proxy().y(), 0.0);
      }
    }
  }
}

// Hard case 18: A4 turns the scene while the proxy sticks to it. The hand stays in place, so that
// its lag turns towards the surface, by less than the cone's width.
TEST(Friction, KeepsItsPlaceInTheSceneWhileA4Turns) {
  OwnedWorld world(plane_soup());
  world.set_effects(with_friction(5.0, 5.0));
  HapticSettings s = hand_settings();
  s.a4.enabled = true;
  s.initial_pose.rotation = Eigen::AngleAxisd(0.25 * std::numbers::pi, Vec3::UnitY());
  const Vec3 normal_device = s.initial_pose.rotation * Vec3::UnitZ();
  auto loop =
      test::made(HapticLoop::create(world.world(), ActuationModel::from_counts(3, 1).value(), s));
  loop.tick(0.001 * normal_device, kTick_s);
  const Vec3 pressed = -0.002 * normal_device;
  const Vec3 rest = vec3(loop.tick(pressed, kTick_s).proxy_scene_m);
  for (int tick = 0; tick < 3000; ++tick) {
    const TickRecord& record = loop.tick(pressed, kTick_s);
    ASSERT_TRUE(record.contact);
    ASSERT_EQ(vec3(record.proxy_scene_m), rest);
  }
  EXPECT_LT(loop.tick(pressed, kTick_s).alpha_rad, 1e-9);  // the alignment is complete
}

// In every step the proxy gets nearer to the goal, on meshes with all kinds of contacts.
TEST(Friction, KeepsTheEnergyCertificate) {
  Random random(5108);
  const TriangleMesh sphere = icosphere(3, 0.05);
  const TriangleMesh ring = torus(0.05, 0.02, 2);
  for (const TriangleMesh* mesh : {&sphere, &ring}) {
    for (const double radius_m : {0.0, 2e-3}) {
      OwnedWorld world(Soup{mesh->positions_m, mesh->triangles}, {}, radius_m);
      world.set_effects(with_friction(0.7, 0.5));
      HapticSettings s = hand_settings();
      s.god_object.radius_m = radius_m;
      auto loop = test::made(HapticLoop::create(world.world(), three_axes(), s));
      Vec3 goal(0.09, 0, 0);
      loop.tick(goal, kTick_s);
      double released_J = 0.0;  // sum F . dx
      double allowed_J = 0.0;   // K/2 sum |dx|^2
      Vec3 force = Vec3::Zero();
      Vec3 proxy = goal;
      int contacts = 0;
      for (int tick = 0; tick < 20000; ++tick) {
        const Vec3 pull = 0.05 * random.unit_vector() - goal;
        const Vec3 step = 4e-4 * random.unit_vector() + 0.01 * pull;
        goal += step;
        released_J += force.dot(step);
        allowed_J += 0.5 * kStiffness_N_per_m * step.squaredNorm();
        const TickRecord& record = loop.tick(goal, kTick_s);
        const double before_m = (proxy - goal).norm();
        proxy = vec3(record.proxy_scene_m);
        const double lag_m = (proxy - goal).norm();
        ASSERT_LE(lag_m, before_m + 1e-15);
        force = kStiffness_N_per_m * (proxy - goal);
        contacts += record.contact;
        ASSERT_LE(released_J + 0.5 * kStiffness_N_per_m * lag_m * lag_m,
                  allowed_J * (1 + 1e-12) + 1e-15);
      }
      EXPECT_GT(contacts, 5000);
    }
  }
}

TEST(Friction, CarriesTheHandWithAMovingPlate) {
  Random random(5109);
  for (const bool turns : {false, true}) {
    const RigidTransform pose = random.pose(0.1);
    OwnedBodies bodies({{plane_soup(), pose}});
    bodies.set_effects(with_friction(5.0, 5.0));
    auto loop = test::made(HapticLoop::create(bodies.world(), three_axes(), hand_settings()));
    loop.tick(pose.point({0.02, 0, 0.001}), kTick_s);
    const Vec3 goal = pose.point({0.02, 0, -0.004});
    loop.tick(goal, kTick_s);
    const Vec3 place = pose.inverse_point(vec3(loop.tick(goal, kTick_s).proxy_scene_m));
    RigidTransform moved = pose;
    for (int tick = 1; tick <= 100; ++tick) {
      const Quat turn(Eigen::AngleAxisd(turns ? 2e-3 * tick : 0.0, Vec3::UnitZ()));
      moved = {pose.rotation * turn, pose.point(turns ? Vec3::Zero() : Vec3(1e-4 * tick, 0, 0))};
      loop.move_body(0, moved);
      const TickRecord& record = loop.tick(goal, kTick_s);
      ASSERT_LE((moved.inverse_point(vec3(record.proxy_scene_m)) - place).norm(), 1e-12) << tick;
    }
    // The force pulls the hand in the direction of the plate's motion.
    const Vec3 pulled = moved.point(place) - goal;
    EXPECT_GT(pulled.dot(vec3(loop.tick(goal, kTick_s).force_device_N)), 0.0);
  }
}

// A corner between a floor that holds the proxy and a frictionless wall that moves along itself.
TEST(Friction, DoesNotCarryTheProxyWithAFrictionlessWall) {
  const RigidTransform wall{Quat(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitY())),
                            Vec3::Zero()};
  OwnedBodies bodies({{plane_soup(), {}}, {plane_soup(), wall}});
  test::EffectBodies effects;
  effects.add_body({test::effect_entry<FrictionEffect>({0.5, 0.4, nullptr})});
  effects.add_body_without_effects();
  bodies.set_effects(effects.finish());
  auto loop = test::made(HapticLoop::create(bodies.world(), three_axes(), hand_settings()));
  loop.tick({0.01, 0, 0.01}, kTick_s);
  const Vec3 pressed(-0.001, 0, -0.001);
  loop.tick(pressed, kTick_s);
  const Vec3 rest = vec3(loop.tick(pressed, kTick_s).proxy_scene_m);
  for (int tick = 1; tick <= 50; ++tick) {
    loop.move_body(1, {wall.rotation, Vec3(0, 1e-4 * tick, 0)});
    const TickRecord& record = loop.tick(pressed, kTick_s);
    ASSERT_TRUE(record.contact);
    ASSERT_LE((vec3(record.proxy_scene_m) - rest).norm(), 1e-11) << tick;
    ASSERT_LE(std::abs(vec3(record.force_device_N).y()), 1e-8) << tick;
  }
}

// A tremor of the body does not cause sliding: static friction still holds.
TEST(Friction, HoldsInAMovingGroove) {
  OwnedBodies bodies({{groove_soup(0.25 * std::numbers::pi), {}}});
  bodies.set_effects(with_friction(0.8, 0.2));
  auto loop = test::made(HapticLoop::create(bodies.world(), three_axes(), hand_settings()));
  loop.tick({0, 0, 0.002}, kTick_s);
  loop.tick({0, 0, -0.002}, kTick_s);
  const double depth = 0.002;
  for (int i = 1; i <= 10; ++i) loop.tick({0, 1e-4 * i, -depth}, kTick_s);
  const Vec3 goal(0, 1e-3, -depth);  // half of the depth: between the two coefficients
  for (int tick = 0; tick < 100; ++tick) {
    loop.move_body(0, {Quat::Identity(), Vec3(0, 0, tick % 2 == 0 ? 1e-6 : 0.0)});
    const TickRecord& record = loop.tick(goal, kTick_s);
    ASSERT_LE(std::abs(vec3(record.proxy_scene_m).y()), 1e-9) << tick;
  }
}

TEST(Friction, HoldsOnlyInContact) {
  PlaneHand hand({}, 10.0, 10.0);
  hand.tick({0, 0, 0.001});
  hand.tick({0, 0, -0.001});
  hand.tick({0.005, 0, -0.001});
  EXPECT_NEAR(hand.proxy().x(), 0.0, hand.tolerance_m());
  hand.tick({0.005, 0, 0.001});
  EXPECT_EQ(hand.proxy(), Vec3(0.005, 0, 0.001));
}

}  // namespace
}  // namespace palpate
