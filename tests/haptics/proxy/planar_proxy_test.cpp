// The proxy of a device with two sensors stays in its plane of motion, whatever bodies do to it. The
// judge knows only the definition: the plane passes through the goal and has the given normal.
//
// The seed determines a scene: PALPATE_SEED=N repeats scene N.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::OwnedBodies;
using test::Random;
using test::Soup;

constexpr int kTicksPerScene = 500;

int scenes_per_kind() {
  return test::in_soak_or_else(20'000'000, 1'000'000) / kTicksPerScene / 4;
}

enum class Policy : std::uint8_t { kPoint, kSphere, kFriction, kInNorm };

double log_uniform(Random& random, double low_exponent, double high_exponent) {
  return std::pow(10.0, random.uniform(low_exponent, high_exponent));
}

// A direction whose component across the plane of motion (here z = 0) dominates, lies in the plane
// to rounding, or is anything.
Vec3 some_normal(Random& random) {
  switch (random.index(3)) {
    case 0:
      return random.unit_vector();
    case 1: {
      Vec3 n = random.unit_vector();
      n.z() *= log_uniform(random, -17.0, -2.0);
      return n.normalized();
    }
    default: {
      Vec3 n = random.unit_vector();
      const double in_plane = log_uniform(random, -9.0, -1.0);
      n.head<2>() *= in_plane;
      n.z() = n.z() < 0.0 ? -1.0 : 1.0;
      return n.normalized();
    }
  }
}

// A triangle of about size_m with a normal of its own, `height_m` from the origin.
void add_triangle(Random& random, Soup& soup, const Vec3& normal, double height_m, double size_m) {
  const Vec3 u = normal.cross(random.unit_vector()).normalized();
  const Vec3 v = normal.cross(u);
  const double turn_rad = random.uniform(0.0, 6.0);
  const auto corner = [&](double angle_rad) {
    const double r_m = size_m * random.uniform(0.3, 1.0);
    return Vec3(height_m * normal + r_m * (std::cos(angle_rad) * u + std::sin(angle_rad) * v));
  };
  soup.add(corner(turn_rad), corner(turn_rad + 2.1), corner(turn_rad + 4.2));
}

// A body around the origin, in the frame of the plane of motion.
Soup some_body(Random& random) {
  Soup soup;
  switch (random.index(6)) {
    case 0:
      return hard_scene(test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))], random)
          .soup;
    case 1:
      return test::box_soup(Vec3::Constant(0.002) + 0.05 * random.in_box(1.0).cwiseAbs());
    case 2: {  // a jaw: a few large faces that face the same way to within a small angle
      const Vec3 normal = some_normal(random);
      const double spread = log_uniform(random, -16.0, 0.0);
      const std::size_t count = 1 + random.index(4);
      for (std::size_t i = 0; i < count; ++i) {
        add_triangle(random, soup, (normal + spread * random.unit_vector()).normalized(),
                     random.index(2) ? 0.0 : 0.01 * random.uniform(-1.0, 1.0), 0.1);
      }
      return soup;
    }
    case 3: {  // a prism across the plane: normals that lie in it to rounding
      const std::size_t count = 3 + random.index(5);
      const double lean = random.index(2) ? 0.0 : log_uniform(random, -16.0, -1.0);
      const auto at = [&](std::size_t i, double z) {
        const double angle_rad = 6.2831853 * static_cast<double>(i % count) / static_cast<double>(count);
        return Vec3(0.03 * std::cos(angle_rad) + lean * z, 0.03 * std::sin(angle_rad), z);
      };
      for (std::size_t i = 0; i < count; ++i) {
        soup.add_quad(at(i, -0.1), at(i + 1, -0.1), at(i + 1, 0.1), at(i, 0.1));
      }
      return soup;
    }
    default: {
      const std::size_t count = 2 + random.index(8);
      for (std::size_t i = 0; i < count; ++i) {
        add_triangle(random, soup, some_normal(random), 0.03 * random.uniform(-1.0, 1.0), 0.06);
      }
      return soup;
    }
  }
}

// A scene of bodies, a planar device among them, and the judge of every tick.
class PlanarRun {
 public:
  PlanarRun(Policy policy, Random& random)
      : random_(random),
        policy_(policy),
        radius_m_(pick_radius_m()),
        anchor_m_(random.index(2) ? Vec3(Vec3::Zero())
                                  : Vec3(0.2 * log_uniform(random, 0.0, 3.0) * random.unit_vector())),
        T_plane_(random.index(8) ? random.pose(0.02) : RigidTransform{}),
        normal_(T_plane_.rotation.toRotationMatrix().col(2)),
        bodies_(make_bodies()),
        god_object_(bodies_.world(), {.radius_m = radius_m_}),
        cones_({0.0, 0.0}),
        norm_(make_norm()) {
    for (std::size_t b = 0; b < bodies_.world().bodies.size(); ++b) {
      judges_.emplace_back(bodies_.triangles(b));
    }
    const double dynamic = random.uniform(0.0, 1.0);
    cones_.cone = {dynamic * random.uniform(1.0, 1.5) + 1e-3, dynamic};
    nearest_m_ = radius_m_ - 64 * std::numeric_limits<double>::epsilon() *
                                 (bodies_.world().size_m + radius_m_) * kFarthest;
    pick_start();
  }

  bool has_start() const { return has_start_; }

  bool tick() {
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      if (!move(b)) return false;
    }
    aim();
    const ProxyState state = follow();
    contacts += state.in_contact;
    if (state.is_refused) return expect(false, "refused");
    for (const Vec3& p : god_object_.path()) {
      if (!is_in_plane(p)) return expect(false, "a corner of the path is off the plane");
    }
    static const bool kNoN = std::getenv("NONORMAL");
    if (!kNoN && std::abs(state.normal.dot(normal_)) > 1e-15 * 16) {
      return expect(false, "the normal is off the plane");
    }
    last_goal_ = goal_;
    ++n_;
    return is_free(god_object_.path());
  }

  int contacts = 0;
  int held = 0;
  int pushed = 0;
  double worst = 0.0;  // height, relative to the rounding of coordinates

 private:
  static constexpr double kFarthest = 8.0;  // of bodies, in sizes, for rounding

  double pick_radius_m() {
    if (policy_ == Policy::kPoint || policy_ == Policy::kInNorm) return 0.0;
    if (policy_ == Policy::kFriction && random_.index(2)) return 0.0;
    return log_uniform(random_, -4.0, -1.5);
  }

  AnisotropicNorm make_norm() {
    const double angle_rad = random_.uniform(0.0, 6.0);
    const Mat3 R = T_plane_.rotation.toRotationMatrix();
    axis_[0] = std::cos(angle_rad) * R.col(0) + std::sin(angle_rad) * R.col(1);
    return AnisotropicNorm(log_uniform(random_, -1.0, 1.0), axis_);
  }

  OwnedBodies make_bodies() {
    std::vector<OwnedBodies::Placed> placed;
    const std::size_t count = 1 + random_.index(4);
    for (std::size_t b = 0; b < count; ++b) {
      RigidTransform T{random_.index(3) ? Quat(Quat::Identity()) : random_.rotation(),
                       random_.in_box(0.1)};
      if (random_.index(2)) T.translation_m.z() *= 1e-2;
      placed.push_back({some_body(random_), {(T_plane_.rotation * T.rotation).normalized(),
                                             T_plane_.point(T.translation_m)}});
    }
    return OwnedBodies(placed, radius_m_);
  }

  // A point of the plane through the device's coordinates, whose rounding the anchor determines.
  Vec3 in_plane(const Vec3& p_plane) const {
    const Mat3 R = T_plane_.rotation.toRotationMatrix();
    const Vec3 p = R * Vec3(p_plane.x(), p_plane.y(), 0.0) + T_plane_.translation_m;
    return Vec3(p + anchor_m_) - anchor_m_;
  }

  void pick_start() {
    for (int i = 0; i < 100 && !has_start_; ++i) {
      p_plane_ = random_.in_box(i < 50 ? 0.03 : 0.2);
      goal_ = in_plane(p_plane_);
      has_start_ = true;
      for (std::uint32_t b = 0; b < judges_.size(); ++b) {
        const double d = judges_[b].distance_m(god_object_.world().body(b).to_body(goal_));
        if (d <= 1.01 * radius_m_ + 1e-6) has_start_ = false;
      }
    }
    god_object_.place(goal_);
    last_goal_ = goal_;
  }

  // The motion of a body: towards the proxy, across it, turning, or at random.
  RigidTransform next_pose(std::uint32_t b) {
    const RigidTransform& now = god_object_.world().body(b).T_solver_body;
    if (habits_.size() <= b) habits_.push_back({});
    Habit& habit = habits_[b];
    if (habit.left-- <= 0) {
      habit.left = 1 + static_cast<int>(random_.index(40));
      habit.kind = static_cast<int>(random_.index(5));
      const double speed_m = log_uniform(random_, -6.0, -1.5);
      Vec3 along = random_.unit_vector();
      if (random_.index(2)) along.z() = 0.0;
      along = T_plane_.rotation * along;
      if (habit.kind <= 1) {  // towards the proxy, from any of its triangles
        const auto& triangles = judges_[b].triangles();
        const test::Corners& t = triangles[random_.index(triangles.size())];
        const Vec3 from = god_object_.world().body(b).to_solver((t.a + t.b + t.c) / 3.0);
        along = god_object_.proxy() - from;
        if (along.norm() > 0.0) along.normalize();
        if (habit.kind == 1) {  // along the normal of the triangle
          const Vec3 n = god_object_.world().body(b).direction_to_solver((t.b - t.a).cross(t.c - t.a).normalized());
          along = n.dot(along) < 0.0 ? Vec3(-n) : n;
        }
      }
      habit.step_m = speed_m * along;
      habit.turn_rad = log_uniform(random_, -6.0, -0.5) * random_.unit_vector();
      if (random_.index(2)) {
        habit.turn_rad = (random_.index(2) ? 1.0 : -1.0) * habit.turn_rad.norm() * normal_;
      }
      habit.turns = random_.index(2) == 0;
    }
    RigidTransform to = now;
    if (habit.kind == 4) return to;
    to.translation_m += habit.step_m - 0.002 * (now.translation_m - T_plane_.translation_m);
    if (habit.turns) {
      const Quat turn(Eigen::AngleAxisd(habit.turn_rad.norm(), habit.turn_rad.normalized()));
      to.rotation = (turn * now.rotation).normalized();
      // The turn is about the proxy or about the body's own origin.
      if (habit.kind == 3) {
        const Vec3 pivot = god_object_.proxy();
        to.translation_m = pivot + turn * (to.translation_m - pivot);
      }
    }
    return to;
  }

  bool move(std::uint32_t b) {
    const RigidTransform to = next_pose(b);
    const RigidTransform from = god_object_.world().body(b).T_solver_body;
    const Vec3 before = god_object_.proxy();
    std::vector<Vec3> starts;
    for (std::uint32_t i = 0; i < judges_.size(); ++i) {
      starts.push_back(god_object_.world().body(i).to_body(before));
    }
    const BodyMotion motion{b, to};
    const std::size_t not_there = god_object_.move_bodies(std::span(&motion, 1), normal_);
    const RigidTransform& now = god_object_.world().body(b).T_solver_body;
    const auto is_at = [&](const RigidTransform& T) {
      return now.rotation.coeffs() == T.rotation.coeffs() && now.translation_m == T.translation_m;
    };
    held += not_there > 0;
    pushed += god_object_.proxy() != before;
    if (is_at(to) != (not_there == 0)) return expect(false, "a held body is not reported");
    if (not_there > 0 && !is_at(from)) return expect(false, "a held body has moved");
    if (!is_in_plane(god_object_.proxy())) {
      return expect(false, "a body pushed the proxy off the plane");
    }
    for (std::uint32_t i = 0; i < judges_.size(); ++i) {
      const Vec3 path[] = {starts[i], god_object_.world().body(i).to_body(god_object_.proxy())};
      if (!is_free_in(i, path)) return expect(false, "a body passed the proxy");
    }
    return true;
  }

  void aim() {
    if (n_ % 25 == 0) {
      aimed_ = random_.index(judges_.size());
      const auto& triangles = judges_[aimed_].triangles();
      const test::Corners& t = triangles[random_.index(triangles.size())];
      aim_body_ = random_.index(2) ? t.a : (t.a + t.b + t.c) / 3.0;
      pace_ = random_.index(4) ? random_.uniform(0.0, 0.3) : 0.0;
      jitter_m_ = random_.index(3) ? log_uniform(random_, -9.0, -3.0) : 0.0;
    }
    const Vec3 aim =
        T_plane_.inverse_point(god_object_.world().body(static_cast<std::uint32_t>(aimed_)).to_solver(aim_body_));
    p_plane_ += pace_ * (aim - p_plane_) + random_.in_box(jitter_m_);
    if (p_plane_.norm() > 1.0) p_plane_ /= p_plane_.norm();
    goal_ = in_plane(p_plane_);
  }

  ProxyState follow() {
    if (policy_ == Policy::kFriction) {
      return god_object_.move_with_friction(goal_, normal_, {cones_, anchor_m_.lpNorm<1>()});
    }
    if (policy_ == Policy::kInNorm) return god_object_.move_in_norm(goal_, normal_, norm_);
    return god_object_.move_to(goal_, normal_);
  }

  bool is_in_plane(const Vec3& p) {
    using Wide3 = ExactJudge::Wide3;
    const auto wide = [](const Vec3& v) { return Wide3(v.cast<long double>()); };
    const long double least =
        std::min(std::abs(wide(normal_).dot(wide(p) - wide(goal_))),
                 std::abs(wide(normal_).dot(wide(p) - wide(last_goal_))));
    const double coordinates_m = p.lpNorm<1>() + goal_.lpNorm<1>() + last_goal_.lpNorm<1>() + anchor_m_.lpNorm<1>() + T_plane_.translation_m.lpNorm<1>();
    const double height = static_cast<double>(least) / (0x1p-53 * coordinates_m);
    worst = std::max(worst, height);
    return height <= 32.0;
  }

  bool is_free(std::span<const Vec3> path) {
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      path_body_.clear();
      for (const Vec3& p : path) path_body_.push_back(god_object_.world().body(b).to_body(p));
      if (!is_free_in(b, path_body_)) return expect(false, "the proxy touched a triangle");
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
                    << normal_.dot(god_object_.proxy() - goal_) << ", worst " << worst
                    << ", size " << bodies_.world().size_m << ", seed " << random_.seed();
    }
    return is_so;
  }

  struct Habit {
    int left = 0;
    int kind = 0;
    bool turns = false;
    Vec3 step_m = Vec3::Zero();
    Vec3 turn_rad = Vec3::Zero();
  };

  Random& random_;
  Policy policy_;
  double radius_m_;
  Vec3 anchor_m_;
  RigidTransform T_plane_;
  Vec3 normal_;
  OwnedBodies bodies_;
  GodObject god_object_;
  test::SameCone cones_;
  std::array<Vec3, 1> axis_;
  AnisotropicNorm norm_;
  std::vector<ExactJudge> judges_;
  std::vector<Habit> habits_;
  std::vector<Vec3> path_body_;
  double nearest_m_ = 0.0;
  bool has_start_ = false;
  Vec3 p_plane_ = Vec3::Zero();
  Vec3 goal_ = Vec3::Zero();
  Vec3 last_goal_ = Vec3::Zero();
  std::size_t aimed_ = 0;
  Vec3 aim_body_ = Vec3::Zero();
  double pace_ = 0.0;
  double jitter_m_ = 0.0;
  int n_ = 0;
};

class PlanarProxies : public testing::TestWithParam<Policy> {};

TEST_P(PlanarProxies, StayInTheirPlane) {
  const int scenes = static_cast<int>(test::from_environment("SCENES", scenes_per_kind()));
  const int first = static_cast<int>(test::from_environment("FIRST", 1));
  long contacts = 0, held = 0, pushed = 0, ticks = 0;
  double worst = 0.0;
  int bad = 0;
  for (int seed = first; seed < first + scenes; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    PlanarRun run(GetParam(), random);
    if (!run.has_start()) continue;
    bool is_good = true;
    for (int n = 0; n < kTicksPerScene && is_good; ++n, ++ticks) is_good = run.tick();
    bad += !is_good;
    worst = std::max(worst, run.worst);
    contacts += run.contacts;
    held += run.held;
    pushed += run.pushed;
    if (std::getenv("PALPATE_SEED")) break;
  }
  std::printf("scenes %d bad %d ticks %ld contacts %ld held %ld pushed %ld worst %g\n", scenes, bad, ticks, contacts,
              held, pushed, worst);
}

INSTANTIATE_TEST_SUITE_P(Of, PlanarProxies,
                         testing::Values(Policy::kPoint, Policy::kSphere, Policy::kFriction,
                                         Policy::kInNorm),
                         [](const testing::TestParamInfo<Policy>& of) {
                           switch (of.param) {
                             case Policy::kPoint:
                               return "Points";
                             case Policy::kSphere:
                               return "Spheres";
                             case Policy::kFriction:
                               return "Friction";
                             default:
                               return "AnAnisotropicNorm";
                           }
                         });

}  // namespace
}  // namespace palpate
