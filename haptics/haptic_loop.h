#pragma once

// One tick of haptic rendering with A4: device position in, force and scene pose out.

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"
#include "haptics/a4/scene_pose.h"
#include "haptics/a4/theoretical_rotation.h"
#include "haptics/effects/effect_runner.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/force_sources.h"
#include "haptics/proxy/contact_world.h"
#include "haptics/proxy/god_object.h"
#include "haptics/record_vectors.h"
#include "haptics/strategies/haptic_settings.h"
#include "haptics/strategies/strategy_step.h"
#include "haptics/touch.h"
#include "palpate/record.h"

namespace palpate {

// The longest valid time step. A force that is held longer cannot follow a hand.
inline constexpr double kLongestTick_s = 1.0;
inline constexpr bool is_time_step(double dt_s) {
  return dt_s > 0.0 && dt_s <= kLongestTick_s;  // false for NaN
}

// The fastest motion of a hand that holds a device; only a boxer's fist is as fast. A sample is a
// jump if only a faster motion could reach it and its distance also exceeds the size of the scene.
// A hand at this speed moves 10 mm per tick at 1 kHz.
inline constexpr double kFastestHand_m_per_s = 10.0;

// The haptic loop: the six actions of A4 (Lecuyer et al. 2005, section 3), once per tick.
//
// Thread-safety: one thread owns the loop. After create(), the loop does not allocate, lock,
// throw or use I/O. It is deterministic: equal worlds, settings, samples and body poses give equal
// bits.
class HapticLoop {
 public:
  // The world must outlive the loop. Errors: those of check_settings() (check_settings.h). Not for
  // the haptic thread: allocates.
  static Result<HapticLoop> create(const ContactWorld& world, const ActuationModel& actuation,
                                   const HapticSettings& settings);
  // A moved-from loop may only be destroyed.
  HapticLoop(HapticLoop&&) noexcept;
  HapticLoop& operator=(HapticLoop&&) noexcept;
  ~HapticLoop();

  // Runs one tick and returns its record, which is valid until the next tick. p_device_m: sensed
  // position, device frame. dt_s: time since the last tick, > 0 and at most kLongestTick_s (see
  // use_measured_times). The first good sample places the proxy at the goal.
  //
  // A bad sample keeps the last state, commands zero force and sets a fault bit. A jump is a bad
  // sample, too. A sample is a jump if it is too far from both the last sample and the last good
  // sample. "Too far" is a distance larger than the scene's size and than the distance that a hand
  // can move in the time since that sample (kFastestHand_m_per_s). Without this rule, every
  // obstacle between the two positions would cause a force. If the device stays at the new
  // position, its next sample is good. If the jump was a single outlier, the sample after it is
  // good. In both cases the proxy follows the device and keeps its contacts.
  const TickRecord& tick(const Vec3& p_device_m, double dt_s) noexcept;

  // Brings the code of a tick and the upper part of the search structures into the caches, so that
  // the first ticks are as fast as later ones. Changes nothing: a second loop, which this function
  // creates, moves into the scene. Allocates: call it before the first tick. Does nothing if there
  // is no memory for the second loop.
  void warm_up() const noexcept;

  // States that dt is the measured time between two samples, as in a recorded path, and not the
  // nominal period of a device that samples late or early. A tick may then be of any length, also
  // longer than kLongestTick_s: no hand feels its force. Call it before the first tick. If all
  // ticks have the same length, no bit of a result changes.
  void use_measured_times() noexcept { has_measured_times_ = true; }

  // True if tick() accepts a time step.
  bool accepts(double dt_s) const noexcept {
    return is_time_step(dt_s) || (has_measured_times_ && dt_s > 0.0 && std::isfinite(dt_s));
  }

  // Marks the sample of the next tick as bad, because the device did not sense it. That tick sets
  // kFaultInvalidSample.
  void refuse_sample() noexcept { next_faults_ |= kFaultInvalidSample; }

  // Sets the pose that a body of the world takes in the next good tick. The moving body pushes the
  // proxy ahead of it (GodObject::move_bodies). A body that would crush the proxy stays where it
  // is, and the loop tries to move it again in every tick (kFaultBodyHeld).
  //
  // body: index into the world's bodies. T_scene_body: pose of the body in the scene frame. In the
  // following cases the call changes nothing, and the next tick sets kFaultBadBodyPose: the body
  // does not exist; the pose is not finite; its quaternion is not of unit length; the pose is
  // farther from the scene's middle than kFarthestBodyPerSize scene sizes; more than
  // LiveWorld::kMostMoving bodies would move. Thread-safety: call on the haptic thread, or while no
  // haptic thread runs.
  void move_body(std::uint32_t body, const RigidTransform& T_scene_body) noexcept;

  // Sets kFaultBadBodyPose in the next tick, for a pose that the caller has refused.
  void refuse_body_pose() noexcept { next_faults_ |= kFaultBadBodyPose; }

  // The largest distance of a body from the scene's middle, in scene sizes. At this distance,
  // positions are rounded by up to 2^-53 of the distance, which is more than a thousand times less
  // than the stand-off.
  static constexpr double kFarthestBodyPerSize = 64.0;

  // Sets the axes of motors that turn with the device. The next tick projects forces on these axes
  // and aligns the contact normal with them. A model with other sensed axes changes nothing; the
  // next tick sets kFaultBadActuation. A call before the first tick has the same effect, to the
  // bit, as creating the loop with `actuation`. Call on the haptic thread.
  void set_actuation(const ActuationModel& actuation) noexcept;

  // Turn A4 on or off; choose the part of the force that is commanded; set K and B of surfaces that
  // declare none. They apply from the next tick on. A loop that is switched before its first tick
  // equals, to the bit, a loop that was created with these settings. A4 chooses its direction
  // anew when it is turned on, as in a new contact. The numbers must be such that check_settings()
  // allows them. A4 and the force of a loop with a strategy (HapticSettings::strategy) belong to
  // the strategy; set_a4() and set_force() then change nothing. Call on the haptic thread.
  void set_a4(bool enabled) noexcept;
  void set_force(ForceMode force) noexcept {
    if (!settings_.strategy) settings_.force = force;
  }
  void set_coupling(double stiffness_N_per_m, double damping_Ns_per_m) noexcept;

  // Frees the hand from the next good tick on: the loop gives no force, the scene does not turn,
  // and surfaces do not stop the hand. The proxy is put at the device point and follows it.
  // Whenever something stops it, it is put at the device point again, so that free_track() changes.
  // While free_track() stays, the proxy has crossed no surface, also none of a moving body. A call
  // while the hand is free puts the proxy at the device point again. Call on the haptic thread.
  void free_hand() noexcept;
  // The next tick touches surfaces again. The proxy is where the hand was in the last tick. Call on
  // the haptic thread.
  void hold_hand() noexcept;
  bool is_hand_free() const noexcept { return is_hand_free_; }
  // The number of the free way that the proxy is on, from 1 on; 0: it is put somewhere in the next
  // tick. Call on the haptic thread while the hand is free.
  std::uint64_t free_track() const noexcept { return has_proxy_ ? free_tracks_ : 0; }
  // The place of the proxy, solver frame, and the bodies at their present poses. Call on the haptic
  // thread.
  const Vec3& proxy_solver() const noexcept { return god_object_.proxy(); }
  const LiveWorld& live_world() const noexcept { return god_object_.world(); }

  // The present settings, with what the functions above have changed, and the present motors. Call
  // on the haptic thread.
  const HapticSettings& settings() const noexcept { return settings_; }
  const ActuationModel& actuation() const noexcept { return actuation_; }

  // The bodies that have moved since create(), and the pose of a body in the scene. Call on
  // the haptic thread.
  std::span<const std::uint32_t> moved_bodies() const noexcept {
    return god_object_.world().moving();
  }
  RigidTransform T_scene_body(std::uint32_t body) const noexcept;

  // Replaces the parameters of one call of the world's effect program. parameters: all bytes of the
  // effect's Parameters, with values that the effect allows. Call on the haptic thread; other
  // threads use the engine's material_tuner.h.
  void set_effect_parameters(std::uint32_t call, std::span<const std::byte> parameters) noexcept {
    if (effects_) effects_->set_parameters(call, parameters);
  }

  // Of the last tick. Call on the haptic thread.
  ForceSources force_sources() const noexcept;

  // Null in a world without effects.
  const EffectCounters* effect_counters() const {
    return effects_ ? &effects_->counters() : nullptr;
  }

  // The scene's pose after the last tick's elementary rotation, for the display.
  ScenePose T_device_scene() const { return pose_after(record_); }

 private:
  static constexpr std::uint32_t kNoMotion = ~std::uint32_t{0};

  // The settings must be valid. god_object: of this world, with settings.god_object.
  HapticLoop(const ContactWorld& world, const ActuationModel& actuation,
             const HapticSettings& settings, GodObject god_object);

  // The parts of tick(), in its order. Those that are inlined have one caller each, and the cost of
  // a call is measurable in short ticks.
  [[gnu::always_inline]] void begin_tick();
  [[gnu::always_inline]] bool get_user_motion(const Vec3& p_device_m, double dt_s);
  [[gnu::always_inline]] std::uint32_t faults_of(const Vec3& sensed_m, double dt_s);
  bool jumps(const Vec3& p_device_m);
  const TickRecord& rest();
  void move_bodies();
  const TickRecord& follow_freely(double dt_s);
  [[gnu::always_inline]] void apply_user_motion();
  void begin_effects(double dt_s);
  [[gnu::always_inline]] void detect_collision(double dt_s);
  [[gnu::always_inline]] void move_proxy(double dt_s);
  [[gnu::always_inline]] void find_contact_normal();
  [[gnu::always_inline]] void render_force(double dt_s);
  [[gnu::always_inline]] Vec3 contact_force_N(double dt_s);
  [[gnu::always_inline]] void command(const Vec3& force_N, double dt_s);
  void end_effects();
  [[gnu::always_inline]] AxisAngle find_theoretical_rotation();
  [[gnu::always_inline]] void apply_elementary_rotation(const AxisAngle& theoretical, double dt_s);
  [[gnu::always_inline]] const TickRecord& end_tick(double dt_s);

  // Where the strategy enters, in a loop that has one.
  StrategyTick strategy_tick(double dt_s) const;
  CountedSpring counted_spring(const Vec3& lag_m) const;
  void place_scene_by_strategy(double dt_s);
  void turn_scene_by_strategy(double dt_s);

  // The largest distance of a touched face from the proxy's centre.
  double touch_m() const { return god_object_.radius_m() + 4 * god_object_.scale().stand_off_m; }
  bool needs(EffectNeed need) const { return (tick_needs_ & need) != 0; }
  // Effects render the contact. Without them the coupling alone does.
  bool has_effects_in_contact() const { return needs(kNeedsContact) && !response_.without_effects; }
  EffectMotion motion(double dt_s) const;
  std::optional<Vec3> motion_plane_normal() const;
  Vec3 goal_solver_m() const { return world_->to_solver(view(record_.goal_scene_m)); }
  void refuse_force();
  void set_zero_force();
  void place_scene(const ScenePose& T_device_scene);
  void end_contact_force();

  const ContactWorld* world_;
  ActuationModel actuation_;
  HapticSettings settings_;
  GodObject god_object_;
  VirtualCoupling coupling_;
  TheoreticalRotation theoretical_rotation_;

  Mat3 R_device_scene_;  // rotation matrix of the pose after the last tick
  Vec3 normal_device_ = Vec3::Zero();
  // A finite sample and the time since it.
  struct Sample {
    Vec3 p_device_m = Vec3::Zero();
    double age_s = 0.0;
  };
  Sample last_sample_;
  Sample last_good_sample_;
  ProxyState proxy_state_;
  TickRecord record_;
  TouchState touch_;
  bool has_proxy_ = false;
  double world_extent_m_;  // argument of farthest_sample_m()

  bool is_hand_free_ = false;
  std::uint64_t free_tracks_ = 0;
  std::unique_ptr<EffectRunner> effects_;  // null in a world without effects
  // The needs of the effects that can act in this tick: what no effect needs is not computed.
  std::uint32_t tick_needs_ = kNeedsNothing;
  std::unique_ptr<StrategyStep> strategy_;  // null without HapticSettings::strategy
  ContactResponse response_;                // of this tick
  Vec3 coupling_force_N_ = Vec3::Zero();    // of the last tick in contact, solver axes
  EffectMotion motion_;                     // of this tick
  bool last_was_good_ = false;              // the last tick's goal was the hand's position
  double last_dt_s_ = 0.0;                  // of the last good tick
  std::uint64_t steady_ticks_ = 0;          // good ticks before this one, in a row, of the same dt
  bool has_measured_times_ = false;
  std::uint64_t good_ticks_ = 0;
  Vec3 last_goal_m_ = Vec3::Zero();       // scene frame, of a world with effects
  Vec3 velocity_m_per_s_ = Vec3::Zero();  // of the goal, scene frame

  std::vector<BodyMotion> body_motions_;       // requested poses; reserved once
  std::vector<std::uint32_t> motion_of_body_;  // index into body_motions_, or kNoMotion
  bool bodies_have_arrived_ = true;            // at all requested poses
  bool bodies_moved_ = false;                  // in this tick
  double bodies_stretched_m2_ = 0.0;        // by how much they have changed the square of the lag
  std::uint32_t next_faults_ = kFaultNone;  // of calls since the last tick
};

}  // namespace palpate
