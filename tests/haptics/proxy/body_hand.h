#pragma once

// A hand that touches one or more bodies and moves to positions in a frame of the test.

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/made.h"
#include "tests/helpers/mesh_soup.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"

namespace palpate::test {

inline constexpr double kStiffness_N_per_m = 1000.0;

// Settings with a spring and a damper and without rotation of the scene.
inline HapticSettings hand_settings(double stiffness = kStiffness_N_per_m, double damping = 0.0) {
  HapticSettings s;
  s.coupling = {stiffness, damping};
  s.a4.enabled = false;
  return s;
}

// A square in the plane z = 0 that faces up.
inline Soup square_soup(double half_m) {
  Soup soup;
  soup.add_quad({-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0},
                {-half_m, half_m, 0});
  return soup;
}

// One side of a groove along y: the side with x > 0, or the other one. Both sides rise at the angle
// rise_rad.
inline Soup groove_side_soup(double half_m, double rise_rad, bool is_right) {
  const double x = half_m * std::cos(rise_rad);
  const double z = half_m * std::sin(rise_rad);
  Soup soup;
  if (is_right) {
    soup.add_quad({0, -half_m, 0}, {x, -half_m, z}, {x, half_m, z}, {0, half_m, 0});
  } else {
    soup.add_quad({-x, -half_m, z}, {0, -half_m, 0}, {0, half_m, 0}, {-x, half_m, z});
  }
  return soup;
}

// A hand and bodies that all have the same pose. That pose defines the local frame of the test.
class BodyHand {
 public:
  // The effects of the bodies, one entry for each. Fill this member before begin(). Bodies without
  // an entry have no effects.
  EffectBodies effects;

  BodyHand(const std::vector<Soup>& soups, const RigidTransform& pose) : pose_(pose) {
    std::vector<OwnedBodies::Placed> placed;
    for (const Soup& soup : soups) placed.push_back({soup, pose});
    bodies_.emplace(placed);
  }

  void begin(const HapticSettings& settings, int actuators = 3) {
    if (!effects.builder.program.bodies.empty()) bodies_->set_effects(effects.finish());
    loop_ = test::made(HapticLoop::create(
        bodies_->world(), ActuationModel::from_counts(3, actuators).value(), settings));
  }
  // Begins with bodies that have no effects.
  void begin_without_effects(const HapticSettings& settings) {
    loop_ = test::made(
        HapticLoop::create(bodies_->world(), ActuationModel::from_counts(3, 3).value(), settings));
  }

  const TickRecord& go_to(const Vec3& p_local, double dt_s = 1e-3) {
    record_ = loop_->tick(pose_.point(p_local), dt_s);
    return record_;
  }

  const TickRecord& record() const { return record_; }
  // Results of the last tick in the local frame.
  Vec3 goal() const { return pose_.inverse_point(vec3(record_.goal_scene_m)); }
  Vec3 proxy() const { return pose_.inverse_point(vec3(record_.proxy_scene_m)); }
  Vec3 normal() const { return pose_.inverse_direction(vec3(record_.normal_scene)); }
  Vec3 force() const { return pose_.inverse_direction(vec3(record_.full_force_device_N)); }
  bool has_active_effect(std::uint16_t effect) const {
    return (record_.effects >> effect & 1u) != 0;
  }

  const RigidTransform& pose() const { return pose_; }
  HapticLoop& loop() { return *loop_; }
  const ContactWorld& world() const { return bodies_->world(); }
  const SurfaceIndex& index(std::size_t body = 0) const { return *world().bodies[body].index; }

  // Tolerance of positions read back from the scene: the solver's stand-off and the rounding in the
  // pose.
  double tolerance_m() const {
    constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
    return 4 * SolverScale::of(world().size_m, 0.0).stand_off_m +
           kRounding * (pose_.translation_m.norm() + world().size_m);
  }

 private:
  RigidTransform pose_;
  std::optional<OwnedBodies> bodies_;
  std::optional<HapticLoop> loop_;
  TickRecord record_;
};

// Calls f(slot) for every slot of an index, including slots that repeat a triangle.
template <typename F>
void for_each_slot(const SurfaceIndex& index, F f) {
  const std::size_t slots = index.pack_count() * TrianglePack::kLanes;
  for (std::uint32_t slot = 0; slot < slots; ++slot) f(slot);
}

// A smooth closed curve: the sum of a few harmonics with random amplitudes, within the half extents
// about a centre. The curve and all its derivatives are equal at turn 0 and 1.
class SmoothLoop {
 public:
  static constexpr int kHarmonics = 3;

  SmoothLoop(const Vec3& centre, const Vec3& half_extent, Random& random)
      : centre_(centre), half_extent_(half_extent) {
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (Wave& wave : waves_[axis]) {
        wave = {random.uniform(0.2, 1.0), random.uniform(0.0, 2.0 * std::numbers::pi)};
        sum += wave.amplitude;
      }
      for (Wave& wave : waves_[axis]) wave.amplitude /= sum;
    }
  }

  Vec3 at(double turn) const {
    Vec3 p = centre_;
    for (int axis = 0; axis < 3; ++axis) {
      for (int h = 0; h < kHarmonics; ++h) {
        const auto& [amplitude, phase] = waves_[axis][h];
        p[axis] += half_extent_[axis] * amplitude *
                   std::sin(2.0 * std::numbers::pi * (h + 1) * turn + phase);
      }
    }
    return p;
  }

 private:
  struct Wave {
    double amplitude;
    double phase;
  };
  Vec3 centre_;
  Vec3 half_extent_;
  Wave waves_[3][kHarmonics];
};

}  // namespace palpate::test
