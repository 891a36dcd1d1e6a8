#include "haptics/haptic_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptics/check_settings.h"
#include "haptics/haptic_loop_steps.h"
#include "haptics/haptic_loop_strategies.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNoMotion = ~std::uint32_t{0};

}  // namespace

HapticLoop::HapticLoop(const ContactWorld& world, const ActuationModel& actuation,
                       const HapticSettings& settings)
    : world_(&world),
      actuation_(actuation),
      settings_(settings),
      god_object_(world, settings.god_object),
      coupling_(settings.coupling),
      theoretical_rotation_(actuation, settings.a4.table1, settings.a4.align),
      touch_(world),
      has_bad_settings_(check_settings(world, settings).has_value()),
      world_extent_m_(world_extent_m(world)) {
  record_.tick = ~std::uint64_t{0};  // the first tick is 0
  place_scene(unit_pose(settings.initial_pose));
  step_ = &HapticLoop::step<kNeedsNothing>;
  step_without_effects_ = &HapticLoop::run_actions<kNeedsNothing>;
  if (world.effects && (world.effects->needs & kStepNeeds) != 0) {
    effects_ = std::make_unique<EffectRunner>(world, settings.god_object, settings.coupling,
                                              settings.measures_effects);
    step_ = step_with_effects(world.effects->needs);
  }
  if (settings.strategy && !has_bad_settings_) use_strategy();
  body_motions_.reserve(std::min(LiveWorld::kMostMoving, world.bodies.size()));
  motion_of_body_.assign(world.bodies.size(), kNoMotion);
}

HapticLoop::HapticLoop(HapticLoop&&) noexcept = default;
HapticLoop& HapticLoop::operator=(HapticLoop&&) noexcept = default;
HapticLoop::~HapticLoop() = default;

const TickRecord& HapticLoop::tick(const Vec3& p_device_m, double dt_s) noexcept {
  ++record_.tick;
  std::copy_n(record_.q_after_wxyz, 4, record_.q_before_wxyz);
  std::copy_n(record_.o_after_m, 3, record_.o_before_m);
  record_.faults = get_user_motion(p_device_m, dt_s);  // action 1
  record_.faults |= std::exchange(next_faults_, kFaultNone);
  if ((record_.faults & kFaultsWithoutForce) != 0) {
    set_zero_force();
    record_.effects = 0;
    record_.rotation_rad = 0.0;
    end_contact_force();
    touch_.complete_without_touch(record_);
    last_was_good_ = false;
    return record_;
  }
  steady_ticks_ = dt_s == last_dt_s_ ? steady_ticks_ + 1 : 0;
  move_bodies();
  (this->*step_)(dt_s);  // actions 2 to 6: haptic_loop_steps.h
  touch_.complete(god_object_, record_);
  last_was_good_ = true;
  last_dt_s_ = dt_s;
  ++good_ticks_;
  return record_;
}

void HapticLoop::warm_up() const noexcept try {
  if (has_bad_settings_) return;
  HapticLoop other(*world_, actuation_, settings_);
  const Box& box = world_->bounds_solver;
  const Vec3 middle_m = world_->to_scene(0.5 * (box.low + box.high));
  const Vec3 outside_m = middle_m + Vec3(world_->size_m, 0.0, 0.0);
  constexpr int kTicks = 16;  // free motion, the first touch, and a few ticks in contact
  constexpr double kTick_s = 1e-3;
  for (int n = 0; n <= kTicks; ++n) {
    const double share = static_cast<double>(n) / kTicks;
    other.tick(T_device_scene().point(outside_m + share * (middle_m - outside_m)), kTick_s);
  }
} catch (const std::bad_alloc&) {
}

// Action 1: the user's motion Tu, here as the sensed position. Returns fault bits.
inline std::uint32_t HapticLoop::get_user_motion(const Vec3& p_device_m, double dt_s) {
  Vec3 sensed_m = p_device_m;
  if (actuation_.is_planar()) sensed_m.z() = settings_.plane_height_m;
  view(record_.device_m) = sensed_m;
  if (has_bad_settings_) return kFaultBadSettings;
  if (!accepts(dt_s)) return kFaultBadTimeStep;
  if (record_.tick > 0) record_.time_s += dt_s;
  last_sample_.age_s += dt_s;
  last_good_sample_.age_s += dt_s;
  if ((next_faults_ & kFaultInvalidSample) != 0) return kFaultNone;  // tick() adds this fault
  if (!sensed_m.allFinite()) return kFaultNonFiniteSample;
  const double farthest_m = farthest_sample_m(world_extent_m_, T_device_scene());
  if (!(sensed_m.squaredNorm() <= farthest_m * farthest_m)) return kFaultFarSample;
  return jumps(sensed_m) ? kFaultJump : kFaultNone;
}

// True if a sample is too far from both the last sample and the last good one. Remembers the
// sample.
bool HapticLoop::jumps(const Vec3& p_device_m) {
  const auto is_near = [&](const Sample& sample) {
    const double reach_m = std::max(world_->size_m, kFastestHand_m_per_s * sample.age_s);
    return (p_device_m - sample.p_device_m).squaredNorm() <= reach_m * reach_m;
  };
  const bool is_jump = has_proxy_ && !is_near(last_sample_) && !is_near(last_good_sample_);
  last_sample_ = {p_device_m, 0.0};
  if (!is_jump) last_good_sample_ = last_sample_;
  return is_jump;
}

void HapticLoop::move_body(std::uint32_t body, const RigidTransform& T_scene_body) noexcept {
  const RigidTransform T_solver_body{T_scene_body.rotation.normalized(),
                                     world_->to_solver(T_scene_body.translation_m)};
  const double farthest_m = kFarthestBodyPerSize * world_->size_m;
  if (body >= world_->bodies.size() || !is_pose(T_scene_body) ||
      !(T_solver_body.translation_m.squaredNorm() <= farthest_m * farthest_m)) {
    return refuse_body_pose();
  }
  std::uint32_t& motion = motion_of_body_[body];
  if (motion == kNoMotion) {
    if (body_motions_.size() == LiveWorld::kMostMoving) return refuse_body_pose();
    motion = static_cast<std::uint32_t>(body_motions_.size());
    body_motions_.push_back({body, {}});
  }
  body_motions_[motion].T_solver_body = T_solver_body;
  bodies_have_arrived_ = false;
}

void HapticLoop::set_actuation(const ActuationModel& actuation) noexcept {
  if (actuation.sensors() != actuation_.sensors()) {
    next_faults_ |= kFaultBadActuation;
    return;
  }
  actuation_ = actuation;
  theoretical_rotation_.set_actuation(actuation);
}

void HapticLoop::set_a4(bool enabled) noexcept {
  if (enabled == settings_.a4.enabled || settings_.strategy) return;
  settings_.a4.enabled = enabled;
  theoretical_rotation_.reset();
}

void HapticLoop::free_hand() noexcept {
  if (!held_step_) held_step_ = std::exchange(step_, &HapticLoop::step_freely);
  has_proxy_ = false;
}

// Strategies and effects begin as in a first tick.
void HapticLoop::hold_hand() noexcept {
  if (!held_step_) return;
  step_ = std::exchange(held_step_, nullptr);
  last_was_good_ = false;
  end_contact_force();
  if (effects_) effects_->reset_states();
}

// Action 2, and the proxy without contact. A body that would crush the proxy moves all the same,
// because in the next tick the proxy is put at the device point again.
void HapticLoop::step_freely(double /*dt_s*/) {
  apply_user_motion();
  const Vec3 goal_solver = world_->to_solver(view(record_.goal_scene_m));
  if (has_proxy_) {
    proxy_state_ = god_object_.move_to(goal_solver, motion_plane_normal());
    const bool is_stopped =
        proxy_state_.in_contact || proxy_state_.capped || (record_.faults & kFaultBodyHeld) != 0;
    if (is_stopped) has_proxy_ = false;
  } else {
    god_object_.place(goal_solver, motion_plane_normal());
    ++free_tracks_;
    has_proxy_ = true;
  }
  record_.iterations = has_proxy_ ? static_cast<std::uint32_t>(proxy_state_.iterations) : 0;
  proxy_state_ = {};
  proxy_state_.proxy = goal_solver;
  view(record_.proxy_scene_m) = view(record_.goal_scene_m);
  view(record_.normal_scene).setZero();
  record_.contact = 0;
  record_.alpha_rad = 0.0;
  record_.rotation_rad = 0.0;
  record_.effects = 0;
  record_.faults &= ~static_cast<std::uint32_t>(kFaultBodyHeld);
  set_zero_force();
  end_contact_force();
  theoretical_rotation_.reset();
}

void HapticLoop::set_coupling(double stiffness_N_per_m, double damping_Ns_per_m) noexcept {
  settings_.coupling.stiffness_N_per_m = stiffness_N_per_m;
  settings_.coupling.damping_Ns_per_m = damping_Ns_per_m;
  coupling_.set(stiffness_N_per_m, damping_Ns_per_m);
  if (effects_) effects_->set_coupling(stiffness_N_per_m, damping_Ns_per_m);
}

RigidTransform HapticLoop::T_scene_body(std::uint32_t body) const noexcept {
  const RigidTransform& T_solver_body = god_object_.world().body(body).T_solver_body;
  return {T_solver_body.rotation, world_->to_scene(T_solver_body.translation_m)};
}

// Runs before the hand's own motion: moving bodies push the proxy, within the plane of a planar
// device.
void HapticLoop::move_bodies() {
  if (bodies_have_arrived_) return;
  std::size_t held = 0;
  if (has_proxy_) {
    held = god_object_.move_bodies(body_motions_, motion_plane_normal());
  } else {
    for (const BodyMotion& m : body_motions_) god_object_.place_body(m.body, m.T_solver_body);
  }
  bodies_have_arrived_ = held == 0;
  if (held > 0) record_.faults |= kFaultBodyHeld;
}

// The normal of the plane to which a planar device is confined, scene frame; null for 3 sensors.
std::optional<Vec3> HapticLoop::motion_plane_normal() const {
  if (!actuation_.is_planar()) return std::nullopt;
  return R_device_scene_.transpose().col(2);
}

// Action 2: computes the device point in the scene. In the camera metaphor, the scene moves by -Tu
// and the proxy stays at the display's centre. That is left to display_transform(), because the
// contact is the same.
void HapticLoop::apply_user_motion() {
  const Vec3 from_origin_m = view(record_.device_m) - view(record_.o_after_m);
  view(record_.goal_scene_m).noalias() = R_device_scene_.transpose() * from_origin_m;
}

// The velocity of the device point in the scene, by backward difference: a medium then dissipates
// exactly b |dx|^2 / T in each tick.
void HapticLoop::find_velocity(const Vec3& last_goal_m, double dt_s) {
  velocity_m_per_s_.setZero();
  if (last_was_good_) {
    velocity_m_per_s_ = (view(record_.goal_scene_m) - last_goal_m) / dt_s;
  }
}

EffectMotion HapticLoop::motion(double dt_s) const {
  EffectMotion motion;
  motion.dt_s = dt_s;
  motion.longest_dt_s = has_measured_times_ ? dt_s : std::max(dt_s, last_dt_s_);
  motion.ticks = static_cast<double>(good_ticks_);
  motion.steady_ticks = static_cast<double>(steady_ticks_);
  motion.time_s = record_.time_s;
  motion.has_measured_times = has_measured_times_;
  motion.goal_m = world_->to_solver(view(record_.goal_scene_m));
  motion.velocity_m_per_s = velocity_m_per_s_;
  return motion;
}

void HapticLoop::set_zero_force() {
  view(record_.full_force_device_N).setZero();
  view(record_.force_device_N).setZero();
}

// The loop's last check of a force. A force that is not finite (dt is so small that speeds
// overflow) is not commanded, and no state keeps any part of it.
void HapticLoop::refuse_force() {
  record_.faults |= kFaultNonFiniteForce;
  set_zero_force();
  end_contact_force();
  if (effects_) effects_->reset_states();
}

// Ends the contact for states with memory: the next tick acts as the first tick of a contact.
void HapticLoop::end_contact_force() {
  record_.friction = FrictionState::kNone;
  god_object_.end_friction();
  coupling_.reset();
}

void HapticLoop::command(const Vec3& force_N) {
  if (!std::isfinite(force_N.sum())) return refuse_force();
  const Vec3 full_N = R_device_scene_ * force_N;
  view(record_.full_force_device_N) = full_N;
  switch (settings_.force) {
    case ForceMode::kNone:
      view(record_.force_device_N).setZero();
      break;
    case ForceMode::kActuated:
      view(record_.force_device_N) = actuation_.actuated_part(full_N);
      break;
    case ForceMode::kFull:
      view(record_.force_device_N) = full_N;
      break;
  }
}

void HapticLoop::place_scene(const ScenePose& T_device_scene) {
  put(T_device_scene, record_.q_after_wxyz, record_.o_after_m);
  R_device_scene_ = T_device_scene.rotation.toRotationMatrix();
}

// Action 5: Table 1. No rotation off contact.
AxisAngle HapticLoop::find_theoretical_rotation() {
  if (!record_.contact) theoretical_rotation_.reset();
  if (!record_.contact || !settings_.a4.enabled) return {};
  return theoretical_rotation_.update(normal_device_);
}

// Action 6: Figure 3. The pivot is the proxy, so the proxy stays feasible and the spring gains no
// energy.
void HapticLoop::apply_elementary_rotation(const AxisAngle& theoretical, double dt_s) {
  record_.rotation_rad = 0.0;
  if (theoretical.angle_rad == 0.0) return;
  const double angle_rad =
      elementary_rotation_rad(settings_.a4.profile, settings_.a4.step, theoretical.angle_rad, dt_s);
  const ScenePose turned = turned_about(T_device_scene(), view(record_.proxy_scene_m),
                                        {theoretical.axis_device, angle_rad});
  record_.rotation_rad = angle_rad;
  place_scene(turned);
}

}  // namespace palpate
