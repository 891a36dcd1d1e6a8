// The proxy of a device with two sensors stays in its plane of motion, whatever bodies do to it.
// The judge knows only the definition: the plane passes through the goal and has the given normal;
// no body passes the proxy; a body that is not at its new pose is reported and has not moved.
//
// The seed determines a scene: PALPATE_SEED=N repeats scene N.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/proxy/god_object.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/hard_case_proxy.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::OwnedBodies;
using test::Random;
using test::Soup;

constexpr int kPlanarTicks = 500;

int planar_scenes() {
  return test::in_soak_or_else(5'000'000, test::trials(250'000)) / kPlanarTicks;
}

// The accepted height above the plane of motion, relative to the sum of the coordinates' sizes: 1
// for the rounding of the proxy's coordinates, 1 for those of the point of the path before it, 4
// for those of the device point and its way to the goal now and then, and 2 for the height's own;
// all doubled.
constexpr double kPlanarRoundoff = 16 * 0x1p-53;

// A contact normal in the plane: 3 roundings of each axis of the plane, and 5 of the combination;
// all doubled.
constexpr double kNormalRoundoff = 16 * 0x1p-53;

enum class PlanarKind : std::uint8_t { kPoint, kSphere, kFriction, kInNorm };

const char* name_of(PlanarKind kind) {
  constexpr std::array kNames{"Points", "Spheres", "WithFriction", "InANorm"};
  return kNames[static_cast<std::size_t>(kind)];
}

double power_of_ten(Random& random, double low_exponent, double high_exponent) {
  return std::pow(10.0, random.uniform(low_exponent, high_exponent));
}

// A normal of a face, where the plane of motion is z = 0: any direction, one in the plane to within
// rounding or a small angle, or one nearly across the plane.
Vec3 some_normal(Random& random) {
  Vec3 n = random.unit_vector();
  switch (random.index(3)) {
    case 0:
      return n;
    case 1:
      n.z() *= power_of_ten(random, -17.0, -2.0);
      return n.normalized();
    default:
      n.head<2>() *= power_of_ten(random, -9.0, -1.0);
      n.z() = n.z() < 0.0 ? -1.0 : 1.0;
      return n.normalized();
  }
}

void add_triangle(Random& random, Soup& soup, const Vec3& normal, double height_m, double size_m) {
  const Vec3 u = normal.cross(random.unit_vector()).normalized();
  const Vec3 v = normal.cross(u);
  const double turn_rad = random.uniform(0.0, 2 * std::numbers::pi);
  const auto corner = [&](double angle_rad) {
    const double r_m = size_m * random.uniform(0.3, 1.0);
    return Vec3(height_m * normal + r_m * (std::cos(angle_rad) * u + std::sin(angle_rad) * v));
  };
  soup.add(corner(turn_rad), corner(turn_rad + 2.1), corner(turn_rad + 4.2));
}

// A few large faces whose normals differ by anything from rounding to a right angle.
Soup jaw(Random& random) {
  Soup soup;
  const Vec3 normal = some_normal(random);
  const double spread = power_of_ten(random, -16.0, 0.0);
  const std::size_t count = 1 + random.index(4);
  for (std::size_t i = 0; i < count; ++i) {
    const double height_m = random.index(2) ? 0.0 : random.uniform(-0.01, 0.01);
    add_triangle(random, soup, (normal + spread * random.unit_vector()).normalized(), height_m,
                 0.1);
  }
  return soup;
}

// Walls across the plane of motion, which lean a little in most scenes.
Soup prism(Random& random) {
  Soup soup;
  const std::size_t count = 3 + random.index(5);
  const double lean = random.index(2) ? 0.0 : power_of_ten(random, -16.0, -1.0);
  const auto at = [&](std::size_t i, double z) {
    const double angle_rad =
        2 * std::numbers::pi * static_cast<double>(i % count) / static_cast<double>(count);
    return Vec3(0.03 * std::cos(angle_rad) + lean * z, 0.03 * std::sin(angle_rad), z);
  };
  for (std::size_t i = 0; i < count; ++i) {
    soup.add_quad(at(i, -0.1), at(i + 1, -0.1), at(i + 1, 0.1), at(i, 0.1));
  }
  return soup;
}

Soup loose_triangles(Random& random) {
  Soup soup;
  const std::size_t count = 2 + random.index(8);
  for (std::size_t i = 0; i < count; ++i) {
    add_triangle(random, soup, some_normal(random), random.uniform(-0.03, 0.03), 0.06);
  }
  return soup;
}

Soup some_body(Random& random) {
  switch (random.index(6)) {
    case 0:
      return hard_scene(test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))], random)
          .soup;
    case 1:
      return test::box_soup(Vec3::Constant(0.002) + random.in_box(0.05).cwiseAbs());
    case 2:
      return jaw(random);
    case 3:
      return prism(random);
    default:
      return loose_triangles(random);
  }
}

// How a body moves for some ticks.
struct BodyHabit {
  int ticks_left = 0;
  bool rests = false;
  bool turns = false;
  bool turns_about_proxy = false;
  Vec3 step_m = Vec3::Zero();
  Vec3 turn_rad = Vec3::Zero();
};

// A planar device among bodies that are driven at it and around it, and the judge of every tick.
class PlanarRun {
 public:
  PlanarRun(PlanarKind kind, Random& random)
      : random_(random),
        kind_(kind),
        radius_m_(pick_radius_m()),
        device_m_(pick_offset_m()),
        T_solver_plane_(pick_plane()),
        normal_(T_solver_plane_.rotation.toRotationMatrix().col(2)),
        bodies_(make_bodies()),
        god_object_(test::made(GodObject::create(bodies_.world(), {.radius_m = radius_m_}))),
        cones_({}),
        norm_(make_norm()) {
    for (std::size_t b = 0; b < bodies_.world().bodies.size(); ++b) {
      judges_.emplace_back(bodies_.triangles(b));
    }
    const double friction = random.uniform(0.0, 1.0);
    cones_.cone = {friction * random.uniform(1.0, 1.5) + 1e-3, friction};
    // Tolerance for the rounding of positions and distances, as in hard_scene_leak_test.
    const double coordinates_m =
        T_solver_plane_.translation_m.norm() + kFarthest * (bodies_.world().size_m + radius_m_);
    nearest_m_ = radius_m_ - 64 * std::numeric_limits<double>::epsilon() * coordinates_m;
    has_start_ = finds_start();
    god_object_.place(goal_, normal_);
  }

  bool has_start() const { return has_start_; }

  // False if a judgement failed.
  bool tick() {
    if (!move_bodies()) return false;
    aim();
    const ProxyState state = follow();
    if (!expect(!state.is_refused, "the goal is refused")) return false;
    contacts += state.in_contact;
    for (const Vec3& p : god_object_.path()) {
      if (!is_in_plane(p)) return expect(false, "a corner of the path is off the plane");
    }
    const double slope = std::abs(state.normal.dot(normal_));
    if (!expect(slope <= kNormalRoundoff, "the normal is off the plane")) return false;
    last_goal_ = goal_;
    ++n_;
    return is_free(god_object_.path());
  }

  int contacts = 0;
  int pushes = 0;
  int held = 0;

 private:
  static constexpr double kSize_m = 0.2;    // of a scene, about
  static constexpr double kFarthest = 8.0;  // of bodies, in sizes, for rounding

  double pick_radius_m() {
    const bool is_sphere =
        kind_ == PlanarKind::kSphere || (kind_ == PlanarKind::kFriction && random_.index(2) == 0);
    return is_sphere ? power_of_ten(random_, -4.0, -1.5) : 0.0;
  }

  // Zero, or up to 1000 sizes.
  Vec3 pick_offset_m() {
    if (random_.index(2)) return Vec3::Zero();
    return kSize_m * power_of_ten(random_, 0.0, 3.0) * random_.unit_vector();
  }

  RigidTransform pick_plane() {
    if (random_.index(8) == 0) return {};
    return {random_.rotation(), pick_offset_m()};
  }

  AnisotropicNorm make_norm() {
    const double angle_rad = random_.uniform(0.0, 2 * std::numbers::pi);
    const std::array<Vec3, 1> axis{
        T_solver_plane_.direction(Vec3(std::cos(angle_rad), std::sin(angle_rad), 0.0))};
    return AnisotropicNorm(power_of_ten(random_, -1.0, 1.0), axis);
  }

  OwnedBodies make_bodies() {
    std::vector<OwnedBodies::Placed> placed;
    const std::size_t count = 1 + random_.index(4);
    for (std::size_t b = 0; b < count; ++b) {
      const Quat turn = random_.index(3) ? Quat(Quat::Identity()) : random_.rotation();
      Vec3 at = random_.in_box(0.5 * kSize_m);
      if (random_.index(2)) at.z() *= 1e-2;
      placed.push_back(
          {some_body(random_),
           {(T_solver_plane_.rotation * turn).normalized(), T_solver_plane_.point(at)}});
    }
    return OwnedBodies(placed, radius_m_);
  }

  // The goal for a point of the plane. A device far from its origin gives coordinates of which the
  // last digits are missing.
  Vec3 goal_at(const Vec3& p_plane) const {
    const Vec3 p = T_solver_plane_.point(Vec3(p_plane.x(), p_plane.y(), 0.0));
    return Vec3(p + device_m_) - device_m_;
  }

  bool finds_start() {
    for (int i = 0; i < 100; ++i) {
      hand_ = random_.in_box(i < 50 ? 0.03 : kSize_m);
      goal_ = last_goal_ = goal_at(hand_);
      const auto is_clear = [&](std::uint32_t b) {
        const double distance_m = judges_[b].distance_m(placed(b).to_body(goal_));
        return distance_m > 1.01 * radius_m_ + 1e-6;
      };
      bool all_clear = true;
      for (std::uint32_t b = 0; b < judges_.size(); ++b) all_clear = all_clear && is_clear(b);
      if (all_clear) return true;
    }
    return false;
  }

  const ContactBody& placed(std::uint32_t b) const { return god_object_.world().body(b); }

  const test::Corners& some_triangle(std::uint32_t b) {
    const auto& triangles = judges_[b].triangles();
    return triangles[random_.index(triangles.size())];
  }

  // Towards the proxy from some face or along its normal, within the plane of motion, or anywhere.
  Vec3 some_heading(std::uint32_t b) {
    const auto way = random_.index(4);
    Vec3 heading = random_.unit_vector();
    if (way == 0) heading.z() = 0.0;
    heading = T_solver_plane_.direction(heading);
    if (way <= 1) return heading;
    const test::Corners& t = some_triangle(b);
    const Vec3 to_proxy = god_object_.proxy() - placed(b).to_solver((t.a + t.b + t.c) / 3.0);
    if (way == 2) return to_proxy.normalized();
    const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
    const Vec3 along = placed(b).direction_to_solver(normal);
    return along.dot(to_proxy) < 0.0 ? Vec3(-along) : along;
  }

  BodyHabit some_habit(std::uint32_t b) {
    BodyHabit habit;
    habit.ticks_left = 1 + static_cast<int>(random_.index(40));
    habit.rests = random_.index(5) == 0;
    habit.turns = random_.index(2) == 0;
    habit.turns_about_proxy = random_.index(3) == 0;
    habit.step_m = power_of_ten(random_, -6.0, -1.5) * some_heading(b);
    const Vec3 axis = random_.index(2) ? random_.unit_vector() : normal_;
    habit.turn_rad = power_of_ten(random_, -6.0, -0.5) * axis;
    if (random_.index(2)) habit.turn_rad = -habit.turn_rad;
    return habit;
  }

  RigidTransform next_pose(std::uint32_t b) {
    const RigidTransform now = placed(b).T_solver_body;
    if (habits_.size() <= b) habits_.push_back({});
    BodyHabit& habit = habits_[b];
    if (habit.ticks_left-- == 0) habit = some_habit(b);
    if (habit.rests) return now;
    RigidTransform to = now;
    const Vec3 home_m = 0.002 * (T_solver_plane_.translation_m - now.translation_m);
    to.translation_m += habit.step_m + home_m;
    if (!habit.turns) return to;
    const Quat turn(Eigen::AngleAxisd(habit.turn_rad.norm(), habit.turn_rad.normalized()));
    to.rotation = (turn * now.rotation).normalized();
    if (habit.turns_about_proxy) {
      const Vec3& pivot = god_object_.proxy();
      to.translation_m = pivot + turn * (to.translation_m - pivot);
    }
    return to;
  }

  // The bodies move one after the other, so that the way of the proxy is known in the frame of each
  // body; or all in one call, as in a loop.
  bool move_bodies() {
    if (n_ % 50 == 0) move_together_ = random_.index(4) == 0;
    std::vector<BodyMotion> motions;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      motions.push_back({b, next_pose(b)});
      if (move_together_) continue;
      if (!move(motions)) return false;
      motions.clear();
    }
    return motions.empty() || move(motions);
  }

  bool move(std::span<const BodyMotion> motions) {
    const Vec3 before = god_object_.proxy();
    std::vector<RigidTransform> poses;
    std::vector<Vec3> starts;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      poses.push_back(placed(b).T_solver_body);
      starts.push_back(placed(b).to_body(before));
    }
    const std::size_t reported = god_object_.move_bodies(motions, normal_);
    std::size_t not_there = 0;
    for (const BodyMotion& motion : motions) {
      if (is_at(motion.body, motion.T_solver_body)) continue;
      ++not_there;
      if (!is_at(motion.body, poses[motion.body])) return expect(false, "a held body has moved");
    }
    held += not_there > 0;
    pushes += god_object_.proxy() != before;
    if (!expect(reported == not_there, "a held body is not reported")) return false;
    if (!expect(is_in_plane(god_object_.proxy()), "a body pushed the proxy off the plane")) {
      return false;
    }
    if (motions.size() > 1) return true;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      const Vec3 path[] = {starts[b], placed(b).to_body(god_object_.proxy())};
      if (!is_free_in(b, path)) return expect(false, "a body passed the proxy");
    }
    return true;
  }

  bool is_at(std::uint32_t b, const RigidTransform& T) const {
    const RigidTransform& now = placed(b).T_solver_body;
    return now.rotation.coeffs() == T.rotation.coeffs() && now.translation_m == T.translation_m;
  }

  // From time to time, the hand goes for another triangle, or stays with a small tremor.
  void aim() {
    if (n_ % 25 == 0) {
      aimed_ = static_cast<std::uint32_t>(random_.index(judges_.size()));
      const test::Corners& t = some_triangle(aimed_);
      aim_body_ = random_.index(2) ? t.a : Vec3((t.a + t.b + t.c) / 3.0);
      pace_ = random_.index(4) ? random_.uniform(0.0, 0.3) : 0.0;
      tremor_m_ = random_.index(3) ? power_of_ten(random_, -9.0, -3.0) : 0.0;
    }
    const Vec3 aim = T_solver_plane_.inverse_point(placed(aimed_).to_solver(aim_body_));
    hand_ += pace_ * (aim - hand_) + random_.in_box(tremor_m_);
    hand_ /= std::max(1.0, hand_.norm() / (5 * kSize_m));
    goal_ = goal_at(hand_);
  }

  ProxyState follow() {
    switch (kind_) {
      case PlanarKind::kFriction:
        return god_object_.move_with_friction(goal_, normal_, {cones_, device_m_.lpNorm<1>()});
      case PlanarKind::kInNorm:
        return god_object_.move_in_norm(goal_, normal_, norm_);
      default:
        return god_object_.move_to(goal_, normal_);
    }
  }

  // Whether a point is in the plane through this goal or the one before, to within rounding.
  bool is_in_plane(const Vec3& p) const {
    const auto height_m = [&](const Vec3& goal) {
      const auto wide = [](const Vec3& v) { return ExactJudge::Wide3(v.cast<long double>()); };
      return static_cast<double>(std::abs(wide(normal_).dot(wide(p) - wide(goal))));
    };
    const double coordinates_m = p.lpNorm<1>() + goal_.lpNorm<1>() + last_goal_.lpNorm<1>() +
                                 device_m_.lpNorm<1>() + T_solver_plane_.translation_m.lpNorm<1>();
    return std::min(height_m(goal_), height_m(last_goal_)) <= kPlanarRoundoff * coordinates_m;
  }

  bool is_free(std::span<const Vec3> path) {
    std::vector<Vec3> path_body;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      path_body.clear();
      for (const Vec3& p : path) path_body.push_back(placed(b).to_body(p));
      if (!is_free_in(b, path_body)) return expect(false, "the proxy touched a triangle");
    }
    return true;
  }
  bool is_free_in(std::uint32_t b, std::span<const Vec3> path_body) const {
    return radius_m_ == 0.0 ? !judges_[b].touch_of_point(path_body)
                            : !judges_[b].touch_of_sphere(path_body, nearest_m_);
  }

  bool expect(bool is_so, const char* problem) {
    if (!is_so) {
      ADD_FAILURE() << problem << ": tick " << n_ << ", radius " << radius_m_ << ", height "
                    << normal_.dot(god_object_.proxy() - goal_);
    }
    return is_so;
  }

  Random& random_;
  PlanarKind kind_;
  double radius_m_;
  Vec3 device_m_;  // offset of the device's coordinates from those of the solver
  RigidTransform T_solver_plane_;
  Vec3 normal_;
  OwnedBodies bodies_;
  GodObject god_object_;
  test::SameCone cones_;
  AnisotropicNorm norm_;
  std::vector<ExactJudge> judges_;
  std::vector<BodyHabit> habits_;
  double nearest_m_ = 0.0;
  bool has_start_ = false;
  bool move_together_ = false;
  Vec3 hand_ = Vec3::Zero();  // in the frame of the plane, m
  Vec3 goal_ = Vec3::Zero();
  Vec3 last_goal_ = Vec3::Zero();
  std::uint32_t aimed_ = 0;
  Vec3 aim_body_ = Vec3::Zero();
  double pace_ = 0.0;
  double tremor_m_ = 0.0;
  int n_ = 0;
};

// A proxy that is placed on a face is lifted within the plane, or not at all.
TEST(PlanarProxiesPlaced, KeepToTheirPlane) {
  Random random(47);
  int lifts = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const RigidTransform T_solver_plane = random.pose(1.0);
    const Vec3 normal = T_solver_plane.direction(Vec3::UnitZ());
    const OwnedBodies bodies({{some_body(random), T_solver_plane}});
    auto god_object = test::made(GodObject::create(bodies.world(), {}));
    const auto triangles = bodies.triangles(0);
    for (int place = 0; place < 10; ++place) {
      const test::Corners& t = triangles[random.index(triangles.size())];
      const double part = random.index(3) ? random.uniform(0.0, 1.0) : 0.0;
      const Vec3 off = 2 * god_object.scale().stand_off_m * random.in_box(1.0);
      const Vec3 p = T_solver_plane.point(t.a + part * (t.b - t.a)) + off;
      ASSERT_TRUE(god_object.place(p, normal));
      const Vec3 lift = god_object.proxy() - p;
      lifts += !lift.isZero(0.0);
      const double coordinates_m = p.lpNorm<1>() + god_object.proxy().lpNorm<1>();
      ASSERT_LE(std::abs(normal.dot(lift)), kPlanarRoundoff * coordinates_m) << trial;
      ASSERT_LE(lift.norm(), 1e-3 * bodies.world().size_m) << trial;
    }
  }
  EXPECT_GT(lifts, 5000);
}

class PlanarProxies : public testing::TestWithParam<PlanarKind> {};

TEST_P(PlanarProxies, StayInTheirPlane) {
  std::uint64_t seed = 0;
  int contacts = 0;
  int pushes = 0;
  int held = 0;
  const int scenes = planar_scenes();
  for (int scene = 0; scene < scenes;) {
    Random random(++seed);
    PlanarRun run(GetParam(), random);
    if (run.has_start()) {
      ++scene;
      for (int n = 0; n < kPlanarTicks && run.tick(); ++n) {
      }
    }
    ASSERT_FALSE(HasFailure());
    contacts += run.contacts;
    pushes += run.pushes;
    held += run.held;
    if (std::getenv("PALPATE_SEED")) return;
  }
  EXPECT_GT(contacts, scenes * kPlanarTicks / 10);
  EXPECT_GT(pushes, scenes * kPlanarTicks / 20);
  EXPECT_GT(held, scenes * kPlanarTicks / 1000);
}

INSTANTIATE_TEST_SUITE_P(Of, PlanarProxies,
                         testing::Values(PlanarKind::kPoint, PlanarKind::kSphere,
                                         PlanarKind::kFriction, PlanarKind::kInNorm),
                         [](const auto& kind) { return std::string(name_of(kind.param)); });

// The whole loop: a scene that lies tilted and far from the origin in the device frame, and that A4
// turns, with a body that is driven at the proxy. The proxy is in the plane of the device, and the
// record says when the body is held.
TEST(PlanarLoops, KeepTheProxyInThePlaneOfTheDevice) {
  int contacts = 0;
  int held = 0;
  const int scenes = std::max(4, test::trials(100));
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(scenes); ++seed) {
    Random random(seed);
    const OwnedBodies bodies({{jaw(random), {}}, {prism(random), {}}, {some_body(random), {}}});
    ContactWorld world = bodies.world();
    world.anchor_scene_m = 200.0 * random.uniform(0.0, 1.0) * random.unit_vector();
    HapticSettings settings;
    settings.a4.enabled = random.index(2) == 0;
    settings.initial_pose = random.pose(100.0);
    Vec3 hand_m = settings.initial_pose.point(world.to_scene(random.in_box(0.02)));
    settings.plane_height_m = hand_m.z();
    auto loop = test::made(HapticLoop::create(world, *ActuationModel::from_counts(2, 1), settings));
    RigidTransform T_scene_body;
    Vec3 step_m = Vec3::Zero();
    for (int n = 0; n < kPlanarTicks; ++n) {
      if (n % 20 == 0) step_m = power_of_ten(random, -5.0, -2.0) * random.unit_vector();
      T_scene_body = loop.T_scene_body(0);
      const Vec3 home_m = 0.05 * (world.anchor_scene_m - T_scene_body.translation_m);
      T_scene_body.translation_m += step_m + home_m;
      loop.move_body(0, T_scene_body);
      hand_m += random.in_box(1e-3);
      const TickRecord& record = loop.tick(hand_m, test::kTick_s);
      const ScenePose pose = pose_before(record);
      const Vec3 proxy_scene_m = vec3(record.proxy_scene_m);
      const double coordinates_m = world.anchor_scene_m.lpNorm<1>() + proxy_scene_m.lpNorm<1>() +
                                   pose.translation_m.lpNorm<1>() + hand_m.lpNorm<1>();
      const double height_m = pose.point(proxy_scene_m).z() - settings.plane_height_m;
      ASSERT_LE(std::abs(height_m), kPlanarRoundoff * coordinates_m) << "tick " << n;
      const Vec3 at_m = world.to_solver(loop.T_scene_body(0).translation_m);
      const bool is_there =
          (at_m - world.to_solver(T_scene_body.translation_m)).norm() <= 0x1p-50 * coordinates_m;
      ASSERT_EQ((record.faults & kFaultBodyHeld) == 0, is_there) << "tick " << n;
      contacts += record.contact;
      held += !is_there;
    }
    if (std::getenv("PALPATE_SEED")) return;
  }
  EXPECT_GT(contacts, scenes * kPlanarTicks / 20);
  EXPECT_GT(held, scenes);
}

}  // namespace
}  // namespace palpate
