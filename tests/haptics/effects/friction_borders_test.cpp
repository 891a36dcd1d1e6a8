// Friction over borders of materials and over edges. The force of every tick is that of the spring;
// it is within the friction cone of the faces that the proxy touches at the end of the tick, and on
// the dynamic cone while the contact slides; no tick yields more energy than the spring loses. The
// scenes and motions are random, and the judge knows only the definition
// (helpers/friction_judge.h).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/friction_judge.h"
#include "tests/helpers/made.h"
#include "tests/helpers/mesh_soup.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::BorneForce;
using test::Corners;
using test::FrictionFace;
using test::FrictionJudge;
using test::kEpsilon;
using test::kTick_s;
using test::OwnedBodies;
using test::Random;
using test::Soup;

constexpr double kRatio = 1e-9;  // tolerance of the ratio of tangential to normal force

double power(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

constexpr double kMostFriction = 3.0;  // dynamic coefficient

// Coefficients from 0 to 3; half of the materials have a static coefficient that is larger.
FrictionCone random_cone(Random& random) {
  if (random.index(8) == 0) return {};
  const double mu_k = random.index(8) == 0 ? 0.0 : power(random, 0.01, kMostFriction);
  const double mu_s = random.index(2) == 0 ? mu_k : mu_k * random.uniform(1.0, 3.0);
  return {std::max(mu_s, 1e-3), mu_k};
}

// A surface in its own frame, with one material for each triangle.
struct Surface {
  Soup soup;
  std::vector<std::uint16_t> material;  // of each triangle

  void add_quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, std::uint16_t m) {
    soup.add_quad(a, b, c, d);
    material.insert(material.end(), 2, m);
  }
};

enum class Kind { kStrips, kProfile, kBox, kRoom, kBall };
constexpr const char* kKindNames[] = {"strips", "profile", "box", "room", "ball"};

constexpr double kHalf_m = 0.1;

struct Scene {
  Kind kind;
  std::vector<FrictionCone> cones;  // by material
  std::vector<Surface> bodies;      // all in the local frame
  std::vector<Vec3> corners;        // of the profile: x and z
  Vec3 half_extent = Vec3::Zero();
  double radius_m = 0.0;
  bool is_planar = false;
  RigidTransform T_scene_local;
  std::optional<HeightMap> map;  // multiplies the coefficients

  static constexpr double kRepeatsPerMetre = 20.0;  // of the map, along x and y of the local frame

  // The coefficients of a material at a point of the surface.
  FrictionCone cone_at(std::uint16_t material, const Vec3& p_local) const {
    FrictionCone cone = cones[material];
    if (!map) return cone;
    const double part = std::clamp(
        map->value(kRepeatsPerMetre * p_local.x(), kRepeatsPerMetre * p_local.y(), 0.0), 0.0, 1.0);
    return {part * cone.static_friction, part * cone.dynamic_friction};
  }

  // The height of a profile at x.
  double height_m(double x) const {
    std::size_t i = 1;
    while (i + 1 < corners.size() && corners[i].x() < x) ++i;
    const Vec3& from = corners[i - 1];
    const Vec3& to = corners[i];
    return from.z() + (x - from.x()) / (to.x() - from.x()) * (to.z() - from.z());
  }
};

Scene random_scene(Random& random, Kind kind) {
  Scene s;
  s.kind = kind;
  s.T_scene_local = random.pose(0.5);
  const std::size_t count = kind == Kind::kBox || kind == Kind::kRoom ? 6 : 2 + random.index(4);
  const bool is_one_material = random.index(4) == 0;
  for (std::size_t i = 0; i < count; ++i) s.cones.push_back(random_cone(random));
  if (is_one_material) std::fill(s.cones.begin(), s.cones.end(), s.cones.front());
  const bool are_bodies = random.index(2) == 0;  // a body for each material
  s.bodies.resize(are_bodies ? count : 1);
  const auto body = [&](std::size_t m) -> Surface& { return s.bodies[are_bodies ? m : 0]; };
  const auto m16 = [](std::size_t m) { return static_cast<std::uint16_t>(m); };
  switch (kind) {
    case Kind::kStrips: {
      std::vector<double> low{-kHalf_m};
      std::vector<double> high{-kHalf_m};
      const double width = 2.0 * kHalf_m / static_cast<double>(count);
      for (std::size_t i = 1; i < count; ++i) {
        low.push_back(-kHalf_m + width * (static_cast<double>(i) + random.uniform(-0.4, 0.4)));
        high.push_back(-kHalf_m + width * (static_cast<double>(i) + random.uniform(-0.4, 0.4)));
      }
      low.push_back(kHalf_m);
      high.push_back(kHalf_m);
      for (std::size_t i = 0; i < count; ++i) {
        body(i).add_quad({low[i], -kHalf_m, 0}, {low[i + 1], -kHalf_m, 0},
                         {high[i + 1], kHalf_m, 0}, {high[i], kHalf_m, 0}, m16(i));
      }
      break;
    }
    case Kind::kProfile: {
      const std::size_t facets = 2 + random.index(8);
      const double steepest = random.uniform(0.0, 1.4);
      Vec3 at(-kHalf_m, 0, 0);
      s.corners.push_back(at);
      for (std::size_t i = 0; i < facets; ++i) {
        at.x() += 2.0 * kHalf_m / static_cast<double>(facets);
        at.z() += 2.0 * kHalf_m / static_cast<double>(facets) *
                  std::tan(random.uniform(-steepest, steepest));
        s.corners.push_back(at);
        const Vec3& from = s.corners[i];
        const Vec3 side(0, kHalf_m, 0);
        const std::size_t m = i % count;
        body(m).add_quad(from - side, at - side, at + side, from + side, m16(m));
      }
      for (std::size_t m = 0; m < s.bodies.size(); ++m) {
        if (!s.bodies[m].material.empty()) continue;
        s.bodies[m].add_quad({-kHalf_m, -kHalf_m, -1}, {kHalf_m, -kHalf_m, -1},
                             {kHalf_m, kHalf_m, -1}, {-kHalf_m, kHalf_m, -1}, m16(m));
      }
      break;
    }
    case Kind::kBox:
    case Kind::kRoom: {
      s.half_extent =
          kHalf_m * Vec3(random.uniform(0.3, 1), random.uniform(0.3, 1), random.uniform(0.3, 1));
      const Soup box = test::box_soup(s.half_extent);
      for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        const Triangle& corners = box.triangles[t];
        Surface& surface = body(t / 2);
        surface.soup.add(box.positions[corners[0]], box.positions[corners[1]],
                         box.positions[corners[2]]);
        surface.material.push_back(m16(t / 2));
      }
      break;
    }
    case Kind::kBall: {
      s.half_extent = Vec3::Constant(kHalf_m);
      const Soup ball = test::soup_of(icosphere(static_cast<int>(random.index(4)), kHalf_m));
      for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
        const Triangle& corners = ball.triangles[t];
        const std::size_t m = random.index(count);
        Surface& surface = body(m);
        surface.soup.add(ball.positions[corners[0]], ball.positions[corners[1]],
                         ball.positions[corners[2]]);
        surface.material.push_back(m16(m));
      }
      for (std::size_t m = 0; m < s.bodies.size(); ++m) {
        if (!s.bodies[m].material.empty()) continue;
        s.bodies[m].add_quad({-kHalf_m, -kHalf_m, -1}, {kHalf_m, -kHalf_m, -1},
                             {kHalf_m, kHalf_m, -1}, {-kHalf_m, kHalf_m, -1}, m16(m));
      }
      break;
    }
  }
  return s;
}

// A scene and a loop, with what the judge knows about them.
class World {
 public:
  World(const Scene& scene, double K, Random& random) : scene_(scene), K_(K) {
    std::vector<OwnedBodies::Placed> placed;
    for (const Surface& surface : scene.bodies) {
      placed.push_back({surface.soup, scene.T_scene_local});
    }
    bodies_.emplace(placed, scene.radius_m);
    test::EffectBodies effects;
    EffectProgram& program = effects.builder.program;
    if (scene_.map) program.maps.push_back(*scene_.map);
    const HeightMap* map = scene_.map ? &program.maps.front() : nullptr;
    for (const FrictionCone& cone : scene.cones) {
      program.material_of_part.push_back(effects.builder.add_material(std::vector{
          test::effect_entry<FrictionEffect>({cone.static_friction, cone.dynamic_friction, map})}));
    }
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const Surface& surface = scene.bodies[b];
      const SurfaceIndex& index = *bodies_->world().bodies[b].index;
      SurfaceAttributes attributes;
      test::for_each_slot(index, [&](std::uint32_t slot) {
        attributes.part.push_back(surface.material[index.face(slot)]);
        const TriangleGeometry& t = index.triangle(slot);
        CornerCoordinates uv;
        const Vec3* corners[] = {&t.a, &t.b, &t.c};
        for (std::size_t i = 0; i < 3; ++i) {
          uv[i] = {Scene::kRepeatsPerMetre * corners[i]->x(),
                   Scene::kRepeatsPerMetre * corners[i]->y()};
        }
        attributes.friction_uv.push_back(UvMap::over(t, uv));
      });
      program.attributes.push_back(std::move(attributes));
      program.bodies.push_back({&program.attributes.back(), 0});
    }
    bodies_->set_effects(effects.finish());
    HapticSettings settings = test::hand_settings(K);
    settings.god_object.radius_m = scene.radius_m;
    const int sensors = scene.is_planar ? 2 : 3;
    if (scene.is_planar) {
      // The device's z axis is nearly the local y axis.
      const Quat across(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));
      const Quat tilt(Eigen::AngleAxisd(random.uniform(0.0, 0.4), random.unit_vector()));
      const Quat R_device_local = tilt * across;
      T_device_scene_.rotation =
          (R_device_local * scene.T_scene_local.rotation.conjugate()).normalized();
      T_device_scene_.translation_m =
          -(T_device_scene_.rotation * scene.T_scene_local.translation_m);
    } else {
      T_device_scene_ = random.pose(0.5);
    }
    settings.initial_pose = T_device_scene_;
    loop_ = test::made(HapticLoop::create(
        bodies_->world(), ActuationModel::from_counts(sensors, sensors).value(), settings));
    place_faces();
  }

  // Moves all bodies, which share one pose, in the next tick.
  void move(const RigidTransform& T_scene_local) {
    moves_ = true;
    for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b) loop_->move_body(b, T_scene_local);
  }

  const TickRecord& tick(const Vec3& goal_scene) {
    record_ = loop_->tick(T_device_scene_.point(goal_scene), kTick_s);
    if (moves_) place_faces();
    if (scene_.map) set_cones();
    return record_;
  }
  Vec3 goal() const { return vec3(record_.goal_scene_m); }
  Vec3 proxy() const { return vec3(record_.proxy_scene_m); }
  Vec3 force_N() const {
    return T_device_scene_.inverse_direction(vec3(record_.full_force_device_N));
  }
  std::optional<Vec3> motion_plane_normal() const {
    if (!scene_.is_planar) return std::nullopt;
    return T_device_scene_.inverse_direction(Vec3::UnitZ());
  }
  double stand_off_m() const {
    return SolverScale::of(bodies_->world().size_m, scene_.radius_m).stand_off_m;
  }
  const std::vector<FrictionFace>& faces() const { return faces_; }
  const TickRecord& record() const { return record_; }
  HapticLoop& loop() { return *loop_; }
  double K() const { return K_; }

 private:
  void place_faces() {
    faces_.clear();
    for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b) {
      const Surface& surface = scene_.bodies[b];
      const RigidTransform T_scene_body = loop_->T_scene_body(b);
      for (std::size_t t = 0; t < surface.material.size(); ++t) {
        const Triangle& c = surface.soup.triangles[t];
        const auto corner = [&](std::size_t i) {
          return T_scene_body.point(surface.soup.positions[c[i]]);
        };
        faces_.push_back({{corner(0), corner(1), corner(2)}, scene_.cones[surface.material[t]]});
      }
    }
  }
  void set_cones() {
    std::size_t face = 0;
    for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b) {
      const RigidTransform T_scene_body = loop_->T_scene_body(b);
      for (const std::uint16_t material : scene_.bodies[b].material) {
        FrictionFace& f = faces_[face++];
        f.cone = scene_.cone_at(
            material, T_scene_body.inverse_point(test::nearest_point(f.corners, proxy())));
      }
    }
  }

  bool moves_ = false;
  Scene scene_;
  double K_;
  std::optional<OwnedBodies> bodies_;
  RigidTransform T_device_scene_;
  std::optional<HapticLoop> loop_;
  std::vector<FrictionFace> faces_;
  TickRecord record_;
};

// A hand that presses at random depths and moves in random directions at random speeds.
class Hand {
 public:
  Hand(const Scene& scene, Random& random) : scene_(scene), random_(&random) {
    if (scene.kind == Kind::kStrips || scene.kind == Kind::kProfile) at_ = Vec3::Zero();
    change();
  }

  // The next goal in the local frame.
  Vec3 next() {
    if (random_->index(40) == 0) change();
    depth_m_ += 0.05 * (wanted_depth_m_ - depth_m_);
    if (random_->index(3) == 0) heading_ += 0.2 * random_->unit_vector();
    if (scene_.is_planar) heading_.y() = 0.0;
    const Vec3 step = step_m_ * heading_.normalized();
    if (scene_.kind == Kind::kStrips || scene_.kind == Kind::kProfile) {
      at_ += step;
      for (int axis = 0; axis < 2; ++axis) {
        const double most = 0.9 * kHalf_m;
        if (std::abs(at_[axis]) > most) heading_[axis] = -std::copysign(1.0, at_[axis]);
        at_[axis] = std::clamp(at_[axis], -most, most);
      }
      const double z = scene_.kind == Kind::kStrips ? 0.0 : scene_.height_m(at_.x());
      return {at_.x(), at_.y(), z + scene_.radius_m - depth_m_};
    }
    // Around a box or a ball: the direction from the middle turns.
    at_ = (at_ + step / kHalf_m).normalized();
    if (scene_.is_planar) at_.y() = 0.0;
    if (scene_.kind == Kind::kBall) return (kHalf_m + scene_.radius_m - depth_m_) * at_;
    const double sign = scene_.kind == Kind::kBox ? 1.0 : -1.0;
    const Vec3 grown = scene_.half_extent.array() + sign * (scene_.radius_m - depth_m_);
    return at_ / (at_.cwiseAbs().cwiseQuotient(grown)).maxCoeff();
  }

  Vec3 first() const {
    const Vec3 p = at_;
    if (scene_.kind == Kind::kStrips || scene_.kind == Kind::kProfile) {
      return {p.x(), p.y(), 0.3 + (scene_.kind == Kind::kStrips ? 0.0 : scene_.height_m(p.x()))};
    }
    return scene_.kind == Kind::kRoom ? Vec3(0, 0, 0) : Vec3(3.0 * kHalf_m * p);
  }

 private:
  void change() {
    wanted_depth_m_ = random_->index(10) == 0 ? -2e-3 : power(*random_, 1e-4, 2e-2);
    if (random_->index(4) == 0) depth_m_ = wanted_depth_m_;
    step_m_ = power(*random_, 1e-6, 2e-3);
    if (random_->index(2) == 0) heading_ = random_->unit_vector();
  }

  const Scene& scene_;
  Random* random_;
  Vec3 at_ = Vec3::UnitX();
  Vec3 heading_ = Vec3::UnitX();
  double depth_m_ = 1e-3;
  double wanted_depth_m_ = 1e-3;
  double step_m_ = 1e-4;
};

// What a run found. The figures are the largest by which a tick breaks a line, beyond rounding.
struct Findings {
  long ticks = 0;
  long slides = 0;
  long sticks = 0;
  long capped = 0;
  double ratio = 0.0;      // of the force above the static cone of the faces touched at the end
  double dynamic = 0.0;    // distance of the ratio from the dynamic cone while the contact slides
  double spring = 0.0;     // difference of the force from the spring's, relative
  double energy_J = 0.0;   // E' - E + F . dg - K |dg|^2 / 2
  double farther_m = 0.0;  // increase of the distance to the goal
  long law = 0;            // ticks on a plane that keep or leave their place against the law
  long unborne = 0;        // ticks in which no touched faces bear the force
};

// One run of a hand over a scene.
class Motion {
 public:
  Motion(const Scene& scene, Random& random, Findings& findings)
      : scene_(scene),
        world_(scene_, power(random, 100.0, 3000.0), random),
        hand_(scene_, random),
        judge_(scene.radius_m, kTouchPerStandOff * world_.stand_off_m()),
        random_(&random),
        findings_(&findings) {
    world_.tick(scene.T_scene_local.point(hand_.first()));
    remember();
  }

  // The hand moves over bodies at rest.
  void move_hand(int ticks) {
    for (int n = 0; n < ticks; ++n) {
      world_.tick(scene_.T_scene_local.point(hand_.next()));
      judge();
      judge_energy();
      if (scene_.kind == Kind::kStrips && !scene_.map) judge_law();
      remember();
    }
  }

  // The bodies move under a hand at rest, which trembles.
  void move_bodies(int ticks) {
    bodies_move_ = true;
    RigidTransform T_scene_local = scene_.T_scene_local;
    Vec3 hand_scene = scene_.T_scene_local.point(hand_.next());
    world_.tick(hand_scene);
    remember();
    for (int n = 0; n < ticks; ++n) {
      const Quat turn(Eigen::AngleAxisd(random_->uniform(0.0, 1e-3), random_->unit_vector()));
      if (!scene_.is_planar) T_scene_local.rotation = (turn * T_scene_local.rotation).normalized();
      T_scene_local.translation_m = hand_scene - T_scene_local.rotation * hand_.next();
      world_.move(T_scene_local);
      if (random_->index(8) == 0 && !scene_.is_planar) hand_scene += random_->in_box(1e-5);
      world_.tick(hand_scene);
      judge();
      remember();
    }
  }

 private:
  // Largest distance, in stand-offs, at which a proxy touches a face: one stand-off, one more while
  // a face is kept, and the part of a stand-off by which a sphere's turn is off the surface.
  static constexpr double kTouchPerStandOff = 4.0;
  // Size of the coordinates of scene and device, m.
  static constexpr double kSize_m = 2.0;
  // Rounding of a lag that counts as equal to the cone: 128 epsilon (kConeRoundoff) for the sums of
  // the absolute coordinates of proxy, goal, device, origin and body, times 1 + mu.
  static constexpr double kConeRounding_m = 128 * kEpsilon * 4.0 * kSize_m * (1.0 + kMostFriction);

  void remember() {
    last_goal_ = world_.goal();
    last_proxy_ = world_.proxy();
    last_force_N_ = world_.force_N();
    last_lag_ = last_proxy_ - last_goal_;
    was_capped_ = is_capped();
    was_ = world_.record().friction;
  }
  bool is_capped() const { return (world_.record().faults & kFaultSolverCapped) != 0; }

  void judge() {
    Findings& f = *findings_;
    const TickRecord& record = world_.record();
    ++f.ticks;
    if (!record.contact) return;
    f.capped += is_capped();
    f.slides += record.friction == FrictionState::kSlides;
    f.sticks += record.friction == FrictionState::kSticks;
    if (is_capped()) return;
    const Vec3 lag = world_.proxy() - world_.goal();
    const Vec3 force_N = world_.force_N();
    const double K = world_.K();
    // A body that moves away may leave a proxy up to two stand-offs off the place that its slide
    // is computed from.
    const double off_place_m =
        bodies_move_ ? 2.0 * world_.stand_off_m() * (1.0 + kMostFriction) : 0.0;
    const double off_m = (force_N / K - lag).norm() - kConeRounding_m - off_place_m;
    f.spring = std::max(f.spring, off_m / lag.norm());
    // A step that is shorter than the tolerance is not taken.
    const double rounding_m =
        64 * kEpsilon * kSize_m + Accuracy::balanced().tolerance * world_.stand_off_m();
    const auto ways =
        judge_.borne(world_.faces(), world_.proxy(), force_N, world_.motion_plane_normal());
    f.unborne += ways.empty();
    double above = ways.empty() ? 0.0 : std::numeric_limits<double>::infinity();
    double off = above;
    for (const BorneForce& way : ways) {
      const double rounding = K * rounding_m / way.normal_N * (1.0 + way.ratio());
      above = std::min(above, way.above_static() - rounding);
      if (way.slides_freely) off = std::min(off, std::abs(way.off_dynamic()) - rounding);
    }
    // Without friction, a slow sphere rests where it could still gain a little (little_m), and any
    // proxy where its gain is lost in the rounding of squared distances (kMonotoneRoundoff).
    const bool is_none = record.friction == FrictionState::kNone;
    const bool is_slow = is_none && scene_.radius_m > 0.0;
    const double lost = is_none ? std::sqrt(32 * kEpsilon) : 0.0;
    if (!is_slow) f.ratio = std::max(f.ratio, above - lost);
    if (record.friction == FrictionState::kSlides) {
      f.dynamic = std::max(f.dynamic, off - off_of_map());
    }
  }

  // Within touch_m of a face and its edge, the place where a sphere touches is uncertain by
  // sqrt(2 r touch_m); the steepest map changes from 0 to 1 over a texel.
  double off_of_map() const {
    if (!scene_.map) return 0.0;
    double most = 0.0;
    for (const FrictionCone& cone : scene_.cones) most = std::max(most, cone.dynamic_friction);
    const double place_m =
        std::sqrt(2.0 * scene_.radius_m * kTouchPerStandOff * world_.stand_off_m());
    return 2.0 * most * scene_.map->width() * Scene::kRepeatsPerMetre * place_m;
  }

  // A force that was shortened to a cone on which a capped tick could not end yields no bound.
  void judge_energy() {
    const Vec3 lag = world_.proxy() - world_.goal();
    const Vec3 step = world_.goal() - last_goal_;
    const double K = world_.K();
    const double gain_J = 0.5 * K * (lag.squaredNorm() - last_lag_.squaredNorm()) +
                          last_force_N_.dot(step) - 0.5 * K * step.squaredNorm();
    const double rounding_J = 64 * kEpsilon * kSize_m * K * (lag.norm() + step.norm());
    if (!was_capped_) findings_->energy_J = std::max(findings_->energy_J, gain_J - rounding_J);
    const double farther_m = lag.norm() - (last_proxy_ - world_.goal()).norm();
    findings_->farther_m = std::max(findings_->farther_m, farther_m - 64 * kEpsilon * kSize_m);
  }

  // The law on a plane, tick by tick: whether the proxy keeps its place, and where a slide ends.
  void judge_law() {
    const auto before = judge_.touched(world_.faces(), last_proxy_);
    const auto after = judge_.touched(world_.faces(), world_.proxy());
    if (before.size() != 1 || after.size() != 1 || was_ == FrictionState::kNone) return;
    const FrictionCone& from = world_.faces()[before[0]].cone;
    const FrictionCone& to = world_.faces()[after[0]].cone;
    Vec3 normal = scene_.T_scene_local.direction(Vec3::UnitZ());
    if (const auto m = world_.motion_plane_normal()) {
      normal = (normal - normal.dot(*m) * *m).normalized();
    }
    const auto parts = [&](const Vec3& lag) {
      const double depth_m = lag.dot(normal);
      return std::pair((lag - depth_m * normal).norm(), depth_m);
    };
    const auto [lag_m, depth_m] = parts(last_proxy_ - world_.goal());
    const auto [left_m, end_depth_m] = parts(world_.proxy() - world_.goal());
    if (depth_m <= 0.0) return;
    const bool slid = was_ == FrictionState::kSlides;
    const double mu = slid ? from.dynamic_friction : from.static_friction;
    const double rounding_m = 256 * kEpsilon * kSize_m * (1.0 + mu);
    const bool keeps = world_.proxy() == last_proxy_;
    const bool sticks = world_.record().friction == FrictionState::kSticks;
    bool is_right = true;
    if (lag_m < mu * depth_m - rounding_m) {
      is_right = keeps && (!slid || sticks == (lag_m < from.dynamic_friction * depth_m));
    } else if (lag_m > mu * depth_m + rounding_m) {
      const double end_m = to.dynamic_friction * end_depth_m;
      is_right = !keeps && left_m <= end_m + rounding_m &&
                 sticks == (to.holds() && left_m < end_m - rounding_m);
      if (before == after) is_right = is_right && std::abs(left_m - end_m) <= rounding_m;
    }
    findings_->law += !is_right;
  }

  Scene scene_;
  World world_;
  Hand hand_;
  FrictionJudge judge_;
  Random* random_;
  Findings* findings_;
  Vec3 last_goal_, last_proxy_, last_force_N_, last_lag_;
  bool bodies_move_ = false;
  bool was_capped_ = false;
  FrictionState was_ = FrictionState::kNone;
};

struct Case {
  Kind kind;
  bool is_sphere;
  bool is_planar;
};

std::string name_of(const Case& c) {
  return std::string(kKindNames[static_cast<int>(c.kind)]) + (c.is_sphere ? "_sphere" : "_point") +
         (c.is_planar ? "_planar" : "");
}
void PrintTo(const Case& c, std::ostream* out) {
  *out << name_of(c);
}

void print(const std::string& name, const Findings& f) {
  std::printf(
      "%-20s %ld ticks, %ld slide, %ld stick, %ld capped; ratio %.1e, dynamic %.1e, spring %.1e, "
      "energy %.1e J, farther %.1e m, law %ld, unborne %ld\n",
      name.c_str(), f.ticks, f.slides, f.sticks, f.capped, f.ratio, f.dynamic, f.spring, f.energy_J,
      f.farther_m, f.law, f.unborne);
}

void expect_right(const Case& c, const Findings& f) {
  EXPECT_GT(f.slides, f.ticks / 100);
  EXPECT_GT(f.sticks, f.ticks / 100);
  EXPECT_LE(f.ratio, kRatio);
  EXPECT_LE(f.dynamic, kRatio);
  // In a plane of motion, the section with a cylinder about an edge that leans little is a long
  // ellipse. A sphere that cannot move along tangents of it ends within a turn of some stand-offs.
  EXPECT_LE(f.spring, c.is_sphere && c.is_planar ? 100.0 * kRatio : kRatio);
  EXPECT_LE(f.energy_J, 0.0);
  EXPECT_LE(f.farther_m, 0.0);
  EXPECT_EQ(f.law, 0);
  EXPECT_EQ(f.unborne, 0);
  EXPECT_LE(f.capped, c.is_sphere ? f.ticks / 1000 : 0);
}

constexpr int kTicksPerScene = 1000;

Scene scene_of(const Case& c, Random& random) {
  Scene scene = random_scene(random, c.kind);
  scene.radius_m = c.is_sphere ? power(random, 5e-4, 1e-2) : 0.0;
  scene.is_planar = c.is_planar;
  return scene;
}

class FrictionBorders : public testing::TestWithParam<Case> {};

// 1,000,000 ticks over all cases; 20 times as many in the soak.
TEST_P(FrictionBorders, KeepTheConeOfTheLastFacesAndTheEnergyOfTheSpring) {
  Random random(5301);
  Findings findings;
  const int scenes = test::in_soak_or_else(1000, 50);
  for (int i = 0; i < scenes; ++i) {
    Motion(scene_of(GetParam(), random), random, findings).move_hand(kTicksPerScene);
  }
  print(name_of(GetParam()), findings);
  expect_right(GetParam(), findings);
}

TEST_P(FrictionBorders, KeepTheConeUnderAHandAtRestWhileBodiesMove) {
  Random random(5302);
  Findings findings;
  const int scenes = test::in_soak_or_else(100, 10);
  for (int i = 0; i < scenes; ++i) {
    Motion(scene_of(GetParam(), random), random, findings).move_bodies(kTicksPerScene);
  }
  print(name_of(GetParam()), findings);
  expect_right(GetParam(), findings);
}

// The coefficients of a map are those at the place where the slide ends.
TEST_P(FrictionBorders, KeepTheConeOfAMapAtTheEndOfTheSlide) {
  if (GetParam().kind != Kind::kStrips && GetParam().kind != Kind::kProfile) return;
  Random random(5303);
  Findings findings;
  const int scenes = test::in_soak_or_else(200, 20);
  for (int i = 0; i < scenes; ++i) {
    Scene scene = scene_of(GetParam(), random);
    std::vector<float> values(16 * 16);
    for (float& value : values) value = static_cast<float>(random.uniform(0.0, 1.0));
    scene.map = HeightMap::build(16, 16, std::move(values), MapWrap::kRepeat, MapWrap::kRepeat);
    Motion(scene, random, findings).move_hand(kTicksPerScene);
  }
  print(name_of(GetParam()), findings);
  expect_right(GetParam(), findings);
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Kind kind : {Kind::kStrips, Kind::kProfile, Kind::kBox, Kind::kRoom, Kind::kBall}) {
    for (const bool is_planar : {false, true}) {
      for (const bool is_sphere : {false, true}) cases.push_back({kind, is_sphere, is_planar});
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, FrictionBorders, testing::ValuesIn(all_cases()),
                         [](const auto& test) { return name_of(test.param); });

// Without friction, a point goes on over the next face before it touches it. If a map gives that
// face friction where the slide would end, the slide ends on the face, and not in mid-air.
TEST(FrictionBorder, ActsOnlyOnATouchedFaceThatAMapMakesRough) {
  Random random(5304);
  int slides = 0;
  for (int n = 0; n < 200; ++n) {
    Scene scene;
    scene.kind = Kind::kProfile;
    scene.T_scene_local = random.pose(0.5);
    scene.cones = {{random.uniform(0.3, 3.0), 0.0}};
    scene.cones[0].dynamic_friction = scene.cones[0].static_friction * random.uniform(0.2, 1.0);
    scene.corners = {{-kHalf_m, 0, -kHalf_m * random.uniform(0.1, 1.0)},
                     {0, 0, 0},
                     {kHalf_m, 0, -kHalf_m * random.uniform(0.1, 2.0)}};
    scene.bodies.resize(1);
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 side(0, kHalf_m, 0);
      const Vec3& from = scene.corners[i];
      const Vec3& to = scene.corners[i + 1];
      scene.bodies[0].add_quad(from - side, to - side, to + side, from + side, 0);
    }
    // 0 near the ridge, and on the side where the point begins; 1 from x = -35 to -15 mm.
    std::vector<float> values(16, 0.0F);
    std::fill(values.begin() + 5, values.begin() + 11, 1.0F);
    scene.map = HeightMap::build(16, 1, std::move(values), MapWrap::kRepeat, MapWrap::kRepeat);
    World world(scene, 1000.0, random);
    const auto go_to = [&](double x, double depth_m) {
      const Vec3 local(x, random.uniform(-0.01, 0.01), scene.height_m(x) - depth_m);
      world.tick(scene.T_scene_local.point(local));
    };
    go_to(0.008, -0.01);
    go_to(0.008, 0.001);
    go_to(random.uniform(-0.03, -0.02), random.uniform(0.002, 0.02));
    const FrictionJudge judge(0.0, 4.0 * world.stand_off_m());
    ASSERT_FALSE(judge.touched(world.faces(), world.proxy()).empty()) << n;
    const Vec3 lag = world.proxy() - world.goal();
    ASSERT_LE((world.force_N() / world.K() - lag).norm(), kRatio * lag.norm()) << n;
    slides += world.record().friction == FrictionState::kSlides;
  }
  EXPECT_GT(slides, 20);
}

// From ice to rubber: the contact sticks at the border with the lag that it arrives with, and the
// force is the spring's, until the lag has grown to the cone of the rubber.
TEST(FrictionBorder, HoldsTheLagOfIceOnRubber) {
  constexpr double kIce = 0.02;
  constexpr double kRubber = 1.2;
  constexpr double kDepth_m = 2e-3;
  constexpr double kStep_m = 1e-4;
  Soup ice;
  ice.add_quad({-0.1, -0.1, 0}, {0, -0.1, 0}, {0, 0.1, 0}, {-0.1, 0.1, 0});
  Soup rubber;
  rubber.add_quad({0, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {0, 0.1, 0});
  test::BodyHand hand({ice, rubber}, {});
  for (const double mu : {kIce, kRubber}) {
    hand.effects.add_body({test::effect_entry<FrictionEffect>({mu, mu, nullptr})});
  }
  hand.begin(test::hand_settings());
  hand.go_to({-0.003, 0.01, 1e-3});
  double x_m = -0.003;
  double lag_m = 0.0;
  int sticks = 0;
  for (int n = 0; n < 80; ++n, x_m += kStep_m) {
    hand.go_to({x_m, 0.01, -kDepth_m});
    const bool is_on_ice = hand.proxy().x() < 0.0;
    const double grown_m = n == 0 ? 0.0 : lag_m + kStep_m;
    lag_m = x_m - hand.proxy().x();
    if (n == 0) continue;
    const double most_m = (is_on_ice ? kIce : kRubber) * kDepth_m;
    const bool arrives = !is_on_ice && sticks == 0;
    ASSERT_NEAR(lag_m, arrives ? kIce * kDepth_m : std::min(grown_m, most_m), 1e-11) << n;
    ASSERT_NEAR(-hand.force().x(), test::kStiffness_N_per_m * lag_m, 1e-8) << n;
    const bool is_below = lag_m < most_m - 1e-11;
    ASSERT_EQ(hand.record().friction, is_below ? FrictionState::kSticks : FrictionState::kSlides)
        << n;
    sticks += is_below;
  }
  EXPECT_GT(sticks, 20);
}

}  // namespace
}  // namespace palpate
