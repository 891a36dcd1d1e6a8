#pragma once

// Runs the tables of an effect program for one haptic loop.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/box.h"
#include "haptics/effects/effect_program.h"
#include "haptics/proxy/proxy_state.h"

namespace palpate {

// How a contact is felt. Solver frame.
struct ContactResponse {
  Vec3 normal = Vec3::Zero();  // unit: shaded; zero where normals cancel
  double height_m = 0.0;       // of the surface above the mesh, <= 0
  Vec3 slope = Vec3::Zero();   // of that height, tangential; no unit
  CouplingSettings coupling;
  bool without_effects = true;  // as without effects
};

// What it takes of a tick. Solver frame.
struct EffectMotion {
  double dt_s = 0.0;
  double longest_dt_s = 0.0;  // of this tick and the one before
  double ticks = 0.0;         // good ones before this one
  Vec3 goal_m = Vec3::Zero();
  Vec3 velocity_m_per_s = Vec3::Zero();
};

// How much each effect did, by its number in compiled_effects(). Time is counted when asked for.
struct EffectCounters {
  std::array<std::uint64_t, kMostEffects> ticks{};
  std::array<std::int64_t, kMostEffects> time_ns{};
};

// The parameters of the effects as they are now, their states, and how they are run. A tick asks
// in the order of the stages: friction_cone() as often as the solver likes, evaluate_contact(), and
// then the two that add force.
//
// No allocation, lock or exception after construction. One thread owns it.
class EffectRunner {
 public:
  // The world, which must have effects, must outlive the runner. coupling: of surfaces that do not
  // say otherwise. radius_m: of the proxy.
  EffectRunner(const ContactWorld& world, double radius_m, const CouplingSettings& coupling,
               bool measures_time);

  // Whether nothing that has an effect can be met or felt on the way of the proxy to this goal: a
  // tick is then as it is without effects. What look_around() saw tells, for as long as the proxy
  // is not far from there.
  bool is_far_from_all(const LiveWorld& world, const Vec3& proxy, const Vec3& goal) const noexcept {
    const double reach_m2 = far_reach_m_ * far_reach_m_;
    return (goal - far_centre_).squaredNorm() < reach_m2 &&
           (proxy - goal).squaredNorm() < reach_m2 && world.moving().empty();
  }
  // At the end of a tick in which that was not so. touch_m: how far away a proxy may touch.
  void look_around(const LiveWorld& world, const Vec3& proxy, double touch_m) noexcept {
    if (active_ != 0 || program_->everywhere.count != 0 || --ticks_to_look_ > 0) return;
    look_for_nearest(world, proxy, touch_m);
  }

  void begin_tick() noexcept { active_ = held_ = 0; }
  // The effects that were felt in this tick, a bit each. Counts them.
  std::uint32_t end_tick() noexcept;

  // kProxy: at a face that the proxy touches.
  FrictionCone friction_cone(const LiveWorld& world, const FaceContact& contact,
                             const Vec3& proxy) noexcept;

  // kSurface and kForceMap, of all that the proxy touches, each by its share.
  ContactResponse evaluate_contact(const ContactView& contact, const ProxyState& state,
                                   const EffectMotion& motion) noexcept;

  // kForceAdd of the contact that was felt last.
  Vec3 contact_force_N(const ProxyState& state, const ContactResponse& response,
                       const EffectMotion& motion) noexcept;
  // kSurroundings. state: of this tick, in contact or not.
  Vec3 surroundings_force_N(const LiveWorld& world, const ProxyState& state, const Vec3& normal,
                            const EffectMotion& motion) noexcept;

  // The parameters of one effect of a material, as many bytes as they have: those of the call
  // `call` of the program. On the thread that ticks.
  void set_parameters(std::uint32_t call, std::span<const std::byte> parameters) noexcept;

  // Forgets what effects have going on.
  void reset_states() noexcept;

  const EffectCounters& counters() const { return counters_; }

 private:
  struct TouchedMaterial {
    std::uint32_t material;
    double share;
  };

  void look_for_nearest(const LiveWorld& world, const Vec3& proxy, double touch_m) noexcept;
  void run(std::span<const EffectCall> table, EffectTick& tick) noexcept;
  void run_one(const EffectCall& call, EffectTick& tick) noexcept;
  EffectTick& prepared(const ProxyState& state, const EffectMotion& motion) noexcept;
  bool touches_face_without_effects(std::span<const FaceContact> contacts) noexcept;
  void find_touches(const ContactView& contact, const Vec3& lag_m) noexcept;
  FacePoint face_point(const LiveWorld& world, const FaceContact& contact,
                       const Vec3& proxy) const noexcept;

  const EffectProgram* program_;
  CouplingSettings coupling_;
  bool measures_time_;
  std::vector<std::byte> parameters_;
  std::vector<std::byte> states_;
  EffectCounters counters_;
  std::uint32_t active_ = 0;  // in this tick
  std::uint32_t held_ = 0;    // those that held any face that the solver tried

  // What is touched: the faces, and their materials without repetition.
  std::array<Touch, 3> touches_{};
  std::array<double, 3> shares_{};
  std::size_t touch_count_ = 0;
  std::array<TouchedMaterial, 3> materials_{};
  std::size_t material_count_ = 0;

  EffectTick tick_;  // what effects are told, reused

  // Around bodies that have effects; the last box around all that are too many to be asked.
  std::vector<Box> boxes_;
  // Within the first half of a ball about the centre: a proxy keeps as near to the goal as it was,
  // so its way does not leave the ball if both ends are in that half.
  Vec3 far_centre_ = Vec3::Zero();
  double far_reach_m_ = 0.0;
  int ticks_to_look_ = 0;

  // No effect with a place is felt within this ball.
  Vec3 quiet_centre_ = Vec3::Zero();
  double quiet_radius_m_ = 0.0;
};

}  // namespace palpate
