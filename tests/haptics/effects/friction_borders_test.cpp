// Friction over borders of materials and over edges: the force of every tick is within the friction
// cone of the faces that the proxy touches at the end of the tick, and no tick yields more energy
// than the spring loses. The scenes and motions are random; the judge knows only the definition
// (helpers/friction_judge.h).

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/friction_judge.h"
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

// Coefficients from 0 to 3; half of the materials have a static coefficient that is larger.
FrictionCone random_cone(Random& random) {
  if (random.index(8) == 0) return {};
  const double mu_k = random.index(8) == 0 ? 0.0 : power(random, 0.01, 3.0);
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

// Where the hand presses: a path in the scene's frame at a depth, as a function of two parameters.
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
      s.half_extent = kHalf_m * Vec3(random.uniform(0.3, 1), random.uniform(0.3, 1),
                                     random.uniform(0.3, 1));
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
    for (const FrictionCone& cone : scene.cones) {
      program.material_of_part.push_back(effects.builder.add_material(
          std::vector{test::effect_entry<FrictionEffect>(
              {cone.static_friction, cone.dynamic_friction, nullptr})}));
    }
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const Surface& surface = scene.bodies[b];
      const SurfaceIndex& index = *bodies_->world().bodies[b].index;
      SurfaceAttributes attributes;
      test::for_each_slot(index, [&](std::uint32_t slot) {
        attributes.part.push_back(surface.material[index.face(slot)]);
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
    loop_.emplace(bodies_->world(), ActuationModel::from_counts(sensors, sensors).value(),
                  settings);
    place_faces(scene.T_scene_local);
  }

  void place_faces(const RigidTransform& T_scene_local) {
    faces_.clear();
    for (const Surface& surface : scene_.bodies) {
      for (std::size_t t = 0; t < surface.material.size(); ++t) {
        const Triangle& c = surface.soup.triangles[t];
        const auto corner = [&](std::size_t i) {
          return T_scene_local.point(surface.soup.positions[c[i]]);
        };
        faces_.push_back({{corner(0), corner(1), corner(2)}, scene_.cones[surface.material[t]]});
      }
    }
  }

  const TickRecord& tick(const Vec3& goal_scene) {
    record_ = loop_->tick(T_device_scene_.point(goal_scene), kTick_s);
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
    const double on_surface = (at_.cwiseAbs().cwiseQuotient(scene_.half_extent)).maxCoeff();
    const double sign = scene_.kind == Kind::kBox ? 1.0 : -1.0;
    const Vec3 grown = scene_.half_extent.array() + sign * (scene_.radius_m - depth_m_);
    (void)on_surface;
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

struct Counts {
  long ticks = 0, contacts = 0, slides = 0, sticks = 0, capped = 0, none = 0;
  long bad_ratio = 0, bad_dynamic = 0, bad_energy = 0, bad_spring = 0, untouched = 0, no_way = 0;
  double worst_ratio = 0, worst_dynamic = 0, worst_energy_J = 0, worst_spring = 0;
  double worst_of_normal = 0;
  long bad_monotone = 0, moved_above = 0;
};

void run_scene(Random& random, Kind kind, double radius_m, bool is_planar, int ticks,
               Counts& counts) {
  const auto explain = test::from_environment("PALPATE_EXPLAIN", 0);
  static long explained = 0;
  Scene scene = random_scene(random, kind);
  scene.radius_m = radius_m;
  scene.is_planar = is_planar;
  const double K = power(random, 100.0, 3000.0);
  World world(scene, K, random);
  Hand hand(scene, random);
  const FrictionJudge judge(radius_m, 4.0 * world.stand_off_m());
  world.tick(scene.T_scene_local.point(hand.first()));
  Vec3 last_goal = world.goal();
  Vec3 last_proxy = world.proxy();
  Vec3 last_force_N = Vec3::Zero();
  double last_E_J = 0.0;
  const double size_m = 1.0;
  for (int n = 0; n < ticks; ++n) {
    const TickRecord& record = world.tick(scene.T_scene_local.point(hand.next()));
    const Vec3 lag = world.proxy() - world.goal();
    const Vec3 force_N = world.force_N();
    const Vec3 step = world.goal() - last_goal;
    const double E_J = 0.5 * K * lag.squaredNorm();
    const bool capped = (record.faults & kFaultSolverCapped) != 0;
    ++counts.ticks;
    counts.contacts += record.contact;
    counts.capped += capped;
    counts.slides += record.friction == FrictionState::kSlides;
    counts.sticks += record.friction == FrictionState::kSticks;
    counts.none += record.contact && record.friction == FrictionState::kNone;
    std::string why;
    // Energy.
    const double gain_J =
        E_J - last_E_J + last_force_N.dot(step) - 0.5 * K * step.squaredNorm();
    const double rounding_J = 256 * kEpsilon * size_m * K * (lag.norm() + step.norm());
    if (gain_J > rounding_J) {
      ++counts.bad_energy;
      why += " energy " + std::to_string(1e3 * gain_J) + " mJ of " + std::to_string(1e3 * E_J);
    }
    counts.worst_energy_J = std::max(counts.worst_energy_J, gain_J);
    const double before_m = (last_proxy - world.goal()).norm();
    if (lag.norm() > before_m + 64 * kEpsilon) ++counts.bad_monotone;
    if (record.contact) {
      const double off = (force_N - K * lag).norm() / (K * lag.norm());
      const double lag_rounding = 256 * kEpsilon * size_m / lag.norm();
      if (off > 1e-9 + lag_rounding) {
        ++counts.bad_spring;
        char text[200];
        const Vec3 nn = vec3(record.normal_scene);
        std::snprintf(text, sizeof text, " spring %.2e iterations %u lag/depth to normal %.9f force ratio %.9f, depth %.2e step %.2e", off,
                      record.iterations, (lag - lag.dot(nn) * nn).norm() / lag.dot(nn),
                      (force_N - force_N.dot(nn) * nn).norm() / force_N.dot(nn), lag.dot(nn), (world.proxy() - last_proxy).norm());
        why += text;
      }
      counts.worst_spring = std::max(counts.worst_spring, off - lag_rounding);
      // The ratio relative to the rounding of the lag.
      const auto ways =
          judge.borne(world.faces(), world.proxy(), force_N, world.motion_plane_normal());
      if (ways.empty()) {
        ++counts.no_way;
        why += " no way to bear the force";
      } else {
        double above = 1e300, off_dynamic = 1e300;
        for (const BorneForce& way : ways) {
          const double rounding = 64 * kEpsilon * size_m * K / way.normal_N * (1 + way.ratio());
          above = std::min(above, way.above_static() - rounding);
          if (way.slides_freely)
          off_dynamic = std::min(off_dynamic, std::abs(way.off_dynamic()) - rounding);
        }
        if (above > kRatio) {
          ++counts.bad_ratio;
          char text[300];
          std::snprintf(text, sizeof text, " ratio above %.3e, normal force %.2e N, iterations %u, step %.1e ",
                                   above, ways.front().normal_N, record.iterations,
                                   (world.proxy() - last_proxy).norm());
          why += text;
        }
        counts.worst_ratio = std::max(counts.worst_ratio, above);
        if (record.friction == FrictionState::kSlides) {
          if (off_dynamic > kRatio) {
            ++counts.bad_dynamic;
            char text[100];
          std::snprintf(text, sizeof text, " dynamic off %.3e", off_dynamic);
          why += text;
          }
          counts.worst_dynamic = std::max(counts.worst_dynamic, off_dynamic);
        }
      }
    }
    const bool shown = ((explain & 1) != 0 && (why.find("ratio ab") != std::string::npos ||
                                               why.find("dynamic") != std::string::npos ||
                                               why.find("no way") != std::string::npos)) ||
                       ((explain & 2) != 0 && why.find("energy") != std::string::npos) ||
                       ((explain & 4) != 0 && why.find("spring") != std::string::npos);
    if (shown && explained < 40) {
      ++explained;
      for (const BorneForce& way :
           judge.borne(world.faces(), world.proxy(), force_N, world.motion_plane_normal())) {
        std::printf("  [%zu planes, normal off by %.1e: %.9f of %.9f %.9f]", way.normals.size(),
                    (way.normals.front() - vec3(record.normal_scene)).norm(), way.ratio(), way.mu_s,
                    way.mu_k);
      }
      std::printf("%s r %.4f planar %d tick %d%s%s:%s\n", kKindNames[static_cast<int>(kind)],
                  radius_m, is_planar, n, capped ? " capped" : "",
                  record.friction == FrictionState::kSlides   ? " slides"
                  : record.friction == FrictionState::kSticks ? " sticks"
                                                              : " none",
                  why.c_str());
    }
    last_goal = world.goal();
    last_proxy = world.proxy();
    last_force_N = force_N;
    last_E_J = E_J;
  }
}

void print(const char* name, const Counts& c) {
  std::printf(
      "%-18s %8ld ticks %8ld contact %7ld slide %7ld stick %6ld none %5ld capped | ratio %ld (%.1e) "
      "dynamic %ld (%.1e) energy %ld (%.1e mJ) spring %ld (%.1e) no way %ld, farther %ld\n",
      name, c.ticks, c.contacts, c.slides, c.sticks, c.none, c.capped, c.bad_ratio, c.worst_ratio,
      c.bad_dynamic, c.worst_dynamic, c.bad_energy, 1e3 * c.worst_energy_J, c.bad_spring,
      c.worst_spring, c.no_way, c.bad_monotone);
}

TEST(FrictionBorders, Explore) {
  Random random(5301);
  const int scenes = static_cast<int>(test::from_environment("PALPATE_SCENES", 20));
  const int ticks = static_cast<int>(test::from_environment("PALPATE_TICKS", 1000));
  const auto only = test::from_environment("PALPATE_KIND", 99);
  for (int k = 0; k < 5; ++k) {
    if (only != 99 && static_cast<int>(only) != k) continue;
    for (const int proxy : {0, 1, 2, 3}) {
      Counts counts;
      for (int i = 0; i < scenes; ++i) {
        const double radius_m = (proxy & 1) != 0 ? power(random, 5e-4, 1e-2) : 0.0;
        run_scene(random, static_cast<Kind>(k), radius_m, (proxy & 2) != 0, ticks, counts);
      }
      const std::string name = std::string(kKindNames[k]) + ((proxy & 1) != 0 ? " sphere" : "") +
                               ((proxy & 2) != 0 ? " planar" : "");
      print(name.c_str(), counts);
    }
  }
}

}  // namespace
}  // namespace palpate
