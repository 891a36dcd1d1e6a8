#pragma once

// Runs the tables of an effect program for one haptic loop.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/box.h"
#include "haptics/effects/effect_program.h"
#include "haptics/effects/giving_forces.h"
#include "haptics/proxy/god_object.h"
#include "haptics/proxy/proxy_state.h"

namespace palpate {

// The response of a contact: the rendered surface and its coupling. Solver frame.
struct ContactResponse {
  Vec3 normal = Vec3::Zero();  // unit, shaded; zero where normals cancel
  double height_m = 0.0;       // of the rendered surface above the mesh, <= 0
  Vec3 slope = Vec3::Zero();   // gradient of that height, tangential; dimensionless
  CouplingSettings coupling;
  bool without_effects = true;  // the contact is rendered as without effects
};

// The motion in a tick, as input of the effects. Solver frame.
struct EffectMotion {
  double dt_s = 0.0;
  double longest_dt_s = 0.0;  // as in EffectTick
  double ticks = 0.0;         // number of good ticks before this one
  double steady_ticks = 0.0;  // the last of them, in a row, that had the same dt as this one
  double time_s = 0.0;        // of this tick
  bool has_measured_times = false;
  Vec3 goal_m = Vec3::Zero();
  Vec3 velocity_m_per_s = Vec3::Zero();
};

// The activity of each effect; element n is for effect n of compiled_effects(). It consists of the
// number of ticks in which the effect was active and, if measured, the computing time of the
// effect.
struct EffectCounters {
  std::array<std::uint64_t, kMostEffects> ticks{};
  std::array<std::int64_t, kMostEffects> time_ns{};
};

// Runs the effects of one haptic loop, and holds their current parameters and their states. A tick
// runs the stages in order: friction_cone() as often as the solver needs it, then
// evaluate_contact(), contact_force_N() and surroundings_force_N().
//
// Thread-safety: one thread owns a runner. No allocation, lock or exception after construction.
class EffectRunner {
 public:
  // The world must have effects and must outlive the runner. proxy: its radius and the budget of
  // the effects. coupling: the spring and damper of surfaces that declare none.
  EffectRunner(const ContactWorld& world, const GodObjectSettings& proxy,
               const CouplingSettings& coupling, bool measures_time);

  // True if, on the proxy's path to the goal, the proxy cannot meet a surface with effects or enter
  // the range of an effect. In that case, the tick is the same as without effects. The result
  // depends on the last update_far_reach() and is valid while the proxy stays near its position at
  // that call.
  bool is_far_from_all(const LiveWorld& world, const Vec3& proxy, const Vec3& goal) const noexcept {
    const double reach_m2 = far_reach_m_ * far_reach_m_;
    return (goal - far_centre_).squaredNorm() < reach_m2 &&
           (proxy - goal).squaredNorm() < reach_m2 && world.moving().empty();
  }
  // Call this function at the end of each tick for which is_far_from_all() returned false. touch_m:
  // the largest distance of a face that the proxy touches.
  void update_far_reach(const LiveWorld& world, const Vec3& proxy, double touch_m) noexcept {
    if (active_ != 0 || program_->everywhere.count != 0 || --ticks_to_search_ > 0) return;
    find_far_reach(world, proxy, touch_m);
  }

  void begin_tick() noexcept {
    active_ = held_ = 0;
    is_capped_ = false;
    if (gives_) giving_ = no_giving_forces();
    gives_ = false;
  }
  // Returns the effects that were active in this tick, one bit each, and counts them.
  std::uint32_t end_tick() noexcept;

  // Runs stage kProxy for one face that the proxy touches.
  FrictionCone friction_cone(const LiveWorld& world, const FaceContact& contact,
                             const Vec3& proxy) noexcept;

  // Runs the stages kSurface and kForceMap for all faces that the proxy touches, each weighted by
  // its share of the contact force.
  ContactResponse evaluate_contact(const ContactView& contact, const ProxyState& state,
                                   const EffectMotion& motion) noexcept;

  // Runs stage kForceAdd for the contact of the last evaluate_contact().
  Vec3 contact_force_N(const ProxyState& state, const ContactResponse& response,
                       const EffectMotion& motion) noexcept;
  // Runs stage kSurroundings. state: the state in this tick, in contact or not. normal: unit
  // contact normal as rendered, zero without contact. The searches of the effects near objects have
  // the budget Accuracy::effects_budget(): the nearest objects come first.
  Vec3 surroundings_force_N(const LiveWorld& world, const ProxyState& state, const Vec3& normal,
                            const EffectMotion& motion) noexcept;

  // Replaces the parameters of one effect of a material. call: index into the program's calls.
  // parameters: all bytes of the effect's Parameters. Call this function on the thread that owns
  // the runner.
  void set_parameters(std::uint32_t call, std::span<const std::byte> parameters) noexcept;

  // Sets K and B of surfaces that declare none. Call this function on the thread that owns the
  // runner.
  void set_coupling(double stiffness_N_per_m, double damping_Ns_per_m) noexcept {
    coupling_.stiffness_N_per_m = stiffness_N_per_m;
    coupling_.damping_Ns_per_m = damping_Ns_per_m;
  }

  // Resets all effect states to their initial values.
  void reset_states() noexcept;

  // Of this tick. has_giving_forces(): not all of them are zero.
  bool has_giving_forces() const { return gives_; }
  const GivingForces& giving_forces() const { return giving_; }

  // Whether the budget of the effects did not suffice in this tick, and the counted work of the
  // effects in the last tick that ran effects near objects.
  bool is_capped() const { return is_capped_; }
  const WorkMeter& work() const { return work_; }

  const EffectCounters& counters() const { return counters_; }

 private:
  struct TouchedMaterial {
    std::uint32_t material;
    double share;
  };

  // A call of the table `places`, by its distance; of equally distant ones, the first comes first.
  struct Place {
    double distance_m;
    std::uint32_t call;
    bool operator<(const Place& other) const {
      return distance_m > other.distance_m || (distance_m == other.distance_m && call > other.call);
    }
  };

  void find_far_reach(const LiveWorld& world, const Vec3& proxy, double touch_m) noexcept;
  void run_places(std::span<const EffectCall> places, EffectTick& tick) noexcept;
  void run_place(const EffectCall& call, EffectTick& tick) noexcept;
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
  GivingForces giving_ = no_giving_forces();
  bool gives_ = false;
  // By the number of the effect: the place of its force in giving_, or kGivesNothing.
  static constexpr std::uint8_t kGivesNothing = kGivingEffects.size();
  std::array<std::uint8_t, kMostEffects> giving_of_{};
  std::uint32_t held_ = 0;  // friction effects of all faces that the solver tried

  // The touched faces, and their materials without repetition.
  std::array<Touch, 3> touches_{};
  std::array<double, 3> shares_{};
  std::size_t touch_count_ = 0;
  std::array<TouchedMaterial, 3> materials_{};
  std::size_t material_count_ = 0;

  EffectTick tick_;  // input and output of the effects, reused

  WorkMeter work_;
  bool has_budget_;
  bool is_capped_ = false;
  std::vector<Place> order_;          // one for each call of `places`
  std::vector<Vec3> place_forces_N_;  // likewise

  // Boxes around bodies that have effects. If there are too many bodies, the last box covers
  // several of them.
  std::vector<Box> boxes_;
  // No effect is within twice far_reach_m_ of far_centre_. If the goal is within far_reach_m_ of
  // far_centre_ and the proxy is within far_reach_m_ of the goal, the path does not leave the
  // larger ball, because the proxy never gets farther from the goal than it was at first.
  Vec3 far_centre_ = Vec3::Zero();
  double far_reach_m_ = 0.0;
  int ticks_to_search_ = 0;

  // No effect of the table `places` is active while the proxy is inside this ball.
  Vec3 quiet_centre_ = Vec3::Zero();
  double quiet_radius_m_ = 0.0;
};

}  // namespace palpate
