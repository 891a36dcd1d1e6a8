#pragma once

// One tick of haptic rendering with A4: device position in, force and scene pose out.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "haptics/a4/actuation.h"
#include "haptics/a4/elementary_rotation.h"
#include "haptics/a4/scene_pose.h"
#include "haptics/a4/theoretical_rotation.h"
#include "haptics/effects/effect_runner.h"
#include "haptics/effects/virtual_coupling.h"
#include "haptics/proxy/contact_world.h"
#include "haptics/proxy/god_object.h"
#include "haptics/record_vectors.h"
#include "palpate/record.h"

namespace palpate {

// Which part of the coupling force the actuators are told. Independent of what A4 aligns with.
enum class ForceMode : std::uint8_t {
  kNone,
  kActuated,  // projected on the actuated axes
  kFull       // as if every axis had an actuator
};

struct A4Settings {
  bool enabled = true;
  Table1Form table1 = Table1Form::kCorrected;
  RotationProfile profile;
  StepRule step = StepRule::kExact;
};

struct HapticSettings {
  GodObjectSettings god_object;
  CouplingSettings coupling;
  ForceMode force = ForceMode::kActuated;
  A4Settings a4;
  double plane_height_m = 0.0;    // 2 sensors: device and proxy keep to z_device = this
  ScenePose initial_pose;         // T_device_scene at the first tick
  bool measures_effects = false;  // the time of each effect, at the price of asking the clock
};

// The longest tick. What is slower is no servo: a force that is held for so long follows no hand.
inline constexpr double kLongestTick_s = 1.0;
inline constexpr bool is_time_step(double dt_s) {
  return dt_s > 0.0 && dt_s <= kLongestTick_s;  // false for NaN
}

// What no hand that holds a device gets to: a boxer's fist does. A sample that is farther away than
// this speed leads is of no hand, if it is farther than the scene is large, too; a hand that goes
// at it passes 10 mm in a tick at 1 kHz.
inline constexpr double kFastestHand_m_per_s = 10.0;

// The six actions of A4 (Lecuyer et al. 2005, section 3), each tick, on one thread.
//
// No allocation, lock, I/O or exception after construction. Deterministic: the same world,
// settings, samples and poses of bodies give the same bits.
class HapticLoop {
 public:
  // The world must outlive the loop. Settings are to be such that check_settings() has no Error.
  HapticLoop(const ContactWorld& world, const ActuationModel& actuation,
             const HapticSettings& settings);

  // p_device_m: the sensed position. dt_s: time since the last tick, at most kLongestTick_s. The
  // first sample sets the proxy. A bad sample holds the last state, commands zero force and sets a
  // fault bit. A sample that is farther from the last one than the scene is large, and than a hand
  // gets in the time since then (kFastestHand_m_per_s), is bad, too: no hand gets there, and
  // whatever it crossed would push. If the device stays there, the next sample is good, and the
  // proxy follows with its contacts kept; so it does if that was one wild sample.
  const TickRecord& tick(const Vec3& p_device_m, double dt_s) noexcept;

  // The sample of the next tick is bad, as what is not finite is: its device says that it has not
  // sensed it. Sets kFaultInvalidSample.
  void refuse_sample() noexcept { next_faults_ |= kFaultInvalidSample; }

  // Where a body of the world is to be from the next good tick on: it moves there in that tick, and
  // pushes the proxy before it (GodObject::move_bodies). A body that cannot get there, because the
  // proxy would be crushed, tries again every tick. A pose that is not finite, or turned by no unit
  // quaternion, or farther from the middle of the scene than kFarthestBodyPerSize sizes, or of one
  // body more than LiveWorld::kMostMoving, sets kFaultBadBodyPose in the next tick and changes
  // nothing. T_scene_body: that of the world's bodies, moved. Safe on the haptic thread, and from
  // no other while it runs.
  void move_body(std::uint32_t body, const RigidTransform& T_scene_body) noexcept;

  // Sets the fault for a pose that was refused before it got here.
  void refuse_body_pose() noexcept { next_faults_ |= kFaultBadBodyPose; }

  // Keeps the rounding of positions there (2^-53 each) thousands of times below the stand-off.
  static constexpr double kFarthestBodyPerSize = 64.0;

  // Motors that turn with the device: what the next tick projects forces on and aligns with. A
  // model that senses other axes sets kFaultBadActuation in the next tick and changes nothing.
  // Before the first tick it makes the loop one with that model, to the bit. On the haptic thread.
  void set_actuation(const ActuationModel& actuation) noexcept;

  // Changes the parameters of one line of the world's effect program: as many bytes as they have,
  // and such as the effect allows. On the haptic thread; see the engine's material_tuner.h.
  void set_effect_parameters(std::uint32_t call, std::span<const std::byte> parameters) noexcept {
    if (effects_) effects_->set_parameters(call, parameters);
  }

  // Null in a world without effects.
  const EffectCounters* effect_counters() const {
    return effects_ ? &effects_->counters() : nullptr;
  }

  // The pose after the last tick's elementary rotation: what a display should show.
  ScenePose T_device_scene() const { return pose_after(record_); }

 private:
  // A tick after action 1. kNeeds: those of the effects that select a step (kStepNeeds). Defined in
  // haptic_loop_steps.h.
  using Step = void (HapticLoop::*)(double dt_s);
  static Step step_with_effects(std::uint32_t needs);
  template <std::uint32_t kNeeds>
  void step(double dt_s);
  template <std::uint32_t kNeeds>
  void run_actions(double dt_s);
  // Each has one caller, whose ticks are too short for a call.
  template <std::uint32_t kNeeds>
  [[gnu::always_inline]] void detect_collision();
  [[gnu::always_inline]] std::uint32_t get_user_motion(const Vec3& p_device_m, double dt_s);
  template <std::uint32_t kNeeds>
  void find_contact_normal();
  template <std::uint32_t kNeeds>
  void render_force(double dt_s);
  template <std::uint32_t kNeeds>
  Vec3 contact_force_N(double dt_s);
  // What a proxy touches is its radius away, and a few stand-offs.
  double touch_m() const { return god_object_.radius_m() + 4 * god_object_.scale().stand_off_m; }
  EffectMotion motion(double dt_s) const;
  void find_velocity(const Vec3& last_goal_m, double dt_s);

  bool jumps(const Vec3& p_device_m);
  void apply_user_motion();
  void move_bodies();
  std::optional<Vec3> motion_plane_normal() const;
  void command(const Vec3& force_N);
  void refuse_force();
  void give_no_force();
  void place_scene(const ScenePose& T_device_scene);
  void end_contact_force();
  AxisAngle find_theoretical_rotation();
  void apply_elementary_rotation(const AxisAngle& theoretical, double dt_s);

  const ContactWorld* world_;
  ActuationModel actuation_;
  HapticSettings settings_;
  GodObject god_object_;
  VirtualCoupling coupling_;
  TheoreticalRotation theoretical_rotation_;

  Mat3 R_device_scene_;  // of the pose after the last tick, ready to be applied
  Vec3 normal_device_ = Vec3::Zero();
  // A sample that counts, and the time since then.
  struct Sample {
    Vec3 p_device_m = Vec3::Zero();
    double age_s = 0.0;
  };
  Sample last_sample_;
  Sample last_good_sample_;
  ProxyState proxy_state_;
  TickRecord record_;
  bool has_proxy_ = false;
  bool has_bad_settings_;
  double world_extent_m_;  // as farthest_sample_m() asks

  Step step_;
  Step step_without_effects_;              // what is left of a step where no effect is near
  std::unique_ptr<EffectRunner> effects_;  // null where there are none
  ContactResponse response_;               // of this tick
  EffectMotion motion_;                    // likewise
  bool last_was_good_ = false;             // the last tick: its goal is where the hand was
  double last_dt_s_ = 0.0;                 // of the last good tick
  std::uint64_t good_ticks_ = 0;
  Vec3 velocity_m_per_s_ = Vec3::Zero();  // of the goal, scene frame

  std::vector<BodyMotion> body_motions_;       // the last that was asked for, of each; never grows
  std::vector<std::uint32_t> motion_of_body_;  // index into them, or none
  bool bodies_are_there_ = true;               // all of them
  std::uint32_t next_faults_ = kFaultNone;     // of what was asked for before the next tick
};

}  // namespace palpate
