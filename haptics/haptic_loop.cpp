#include "haptics/haptic_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/check_settings.h"
#include "haptics/effects/cones_of_effects.h"
#include "haptics/effects/rendered_force.h"
#include "haptics/record_vectors.h"

namespace palpate {

Result<HapticLoop> HapticLoop::create(const ContactWorld& world, const ActuationModel& actuation,
                                      const HapticSettings& settings) {
  if (auto error = check_settings(world, settings)) return *error;
  auto god_object = GodObject::create(world, settings.god_object);
  if (!god_object) return god_object.error();
  return HapticLoop(world, actuation, settings, std::move(*god_object));
}

HapticLoop::HapticLoop(const ContactWorld& world, const ActuationModel& actuation,
                       const HapticSettings& settings, GodObject god_object)
    : world_(&world),
      actuation_(actuation),
      settings_(settings),
      god_object_(std::move(god_object)),
      coupling_(settings.coupling),
      theoretical_rotation_(actuation, settings.a4.table1, settings.a4.align),
      touch_(world),
      world_extent_m_(world_extent_m(world)) {
  record_.tick = ~std::uint64_t{0};  // the first tick is 0
  place_scene(unit_pose(settings.initial_pose));
  if (world.effects && (world.effects->needs & kTickNeeds) != 0) {
    effects_ = std::make_unique<EffectRunner>(world, settings.god_object, settings.coupling,
                                              settings.measures_effects);
  }
  if (settings.strategy) {
    strategy_ = settings.strategy->type->make_step(actuation_, settings_);
  }
  body_motions_.reserve(std::min(LiveWorld::kMostMoving, world.bodies.size()));
  motion_of_body_.assign(world.bodies.size(), kNoMotion);
}

HapticLoop::HapticLoop(HapticLoop&&) noexcept = default;
HapticLoop& HapticLoop::operator=(HapticLoop&&) noexcept = default;
HapticLoop::~HapticLoop() = default;

const TickRecord& HapticLoop::tick(const Vec3& p_device_m, double dt_s) noexcept {
  begin_tick();
  if (!get_user_motion(p_device_m, dt_s)) return rest();  // action 1
  move_bodies();
  if (is_hand_free_) return follow_freely(dt_s);
  if (strategy_) place_scene_by_strategy(dt_s);
  apply_user_motion();  // action 2
  if (effects_) begin_effects(dt_s);
  detect_collision(dt_s);  // action 3
  find_contact_normal();   // action 4
  render_force(dt_s);
  if (tick_needs_ != kNeedsNothing) end_effects();
  const AxisAngle theoretical = find_theoretical_rotation();  // action 5
  apply_elementary_rotation(theoretical, dt_s);               // action 6
  if (strategy_) turn_scene_by_strategy(dt_s);
  return end_tick(dt_s);
}

inline void HapticLoop::begin_tick() {
  ++record_.tick;
  std::copy_n(record_.q_after_wxyz, 4, record_.q_before_wxyz);
  std::copy_n(record_.o_after_m, 3, record_.o_before_m);
}

// Ends a tick with a good sample.
inline const TickRecord& HapticLoop::end_tick(double dt_s) {
  touch_.complete(god_object_, record_);
  last_was_good_ = true;
  last_dt_s_ = dt_s;
  ++good_ticks_;
  return record_;
}

// A tick without a good sample.
const TickRecord& HapticLoop::rest() {
  set_zero_force();
  record_.effects = 0;
  record_.rotation_rad = 0.0;
  end_contact_force();
  touch_.complete_without_touch(record_);
  last_was_good_ = false;
  return record_;
}

void HapticLoop::warm_up() const noexcept try {
  auto other = create(*world_, actuation_, settings_);
  if (!other) return;  // set_coupling() was called with numbers that it does not allow
  const Box& box = world_->bounds_solver;
  const Vec3 middle_m = world_->to_scene(0.5 * (box.low + box.high));
  const Vec3 outside_m = middle_m + Vec3(world_->size_m, 0.0, 0.0);
  constexpr int kTicks = 16;  // free motion, the first touch, and a few ticks in contact
  constexpr double kTick_s = 1e-3;
  for (int n = 0; n <= kTicks; ++n) {
    const double share = static_cast<double>(n) / kTicks;
    other->tick(T_device_scene().point(outside_m + share * (middle_m - outside_m)), kTick_s);
  }
} catch (const std::bad_alloc&) {
}

// Action 1: the user's motion Tu, here as the sensed position. Returns whether the sample is good.
inline bool HapticLoop::get_user_motion(const Vec3& p_device_m, double dt_s) {
  Vec3 sensed_m = p_device_m;
  if (actuation_.is_planar()) sensed_m.z() = settings_.plane_height_m;
  view(record_.device_m) = sensed_m;
  record_.faults = faults_of(sensed_m, dt_s);
  record_.faults |= std::exchange(next_faults_, kFaultNone);
  if ((record_.faults & kFaultsWithoutForce) != 0) return false;
  steady_ticks_ = dt_s == last_dt_s_ ? steady_ticks_ + 1 : 0;
  return true;
}

inline std::uint32_t HapticLoop::faults_of(const Vec3& sensed_m, double dt_s) {
  if (!accepts(dt_s)) return kFaultBadTimeStep;
  if (record_.tick > 0) record_.time_s += dt_s;
  last_sample_.age_s += dt_s;
  last_good_sample_.age_s += dt_s;
  if ((next_faults_ & kFaultInvalidSample) != 0) return kFaultNone;  // the caller adds this fault
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

// Runs before the hand's own motion: moving bodies push the proxy, within the plane of a planar
// device.
void HapticLoop::move_bodies() {
  bodies_moved_ = !bodies_have_arrived_;
  bodies_stretched_m2_ = 0.0;
  if (bodies_have_arrived_) return;
  std::size_t held = 0;
  if (has_proxy_) {
    const Vec3 goal_m = goal_solver_m();  // of the last tick
    const auto lag_m2 = [&] {
      const Vec3 lag_m = god_object_.proxy() - goal_m;
      if (!strategy_) return lag_m.squaredNorm();
      const double counted_m = counted_spring(lag_m).lag_m;
      return counted_m * counted_m;
    };
    const double before_m2 = lag_m2();
    held = god_object_.move_bodies(body_motions_, motion_plane_normal());
    bodies_stretched_m2_ = lag_m2() - before_m2;
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
inline void HapticLoop::apply_user_motion() {
  const Vec3 from_origin_m = view(record_.device_m) - view(record_.o_after_m);
  view(record_.goal_scene_m).noalias() = R_device_scene_.transpose() * from_origin_m;
}

// Action 2, and the proxy without contact. A body that would crush the proxy moves all the same,
// because in the next tick the proxy is put at the device point again.
const TickRecord& HapticLoop::follow_freely(double dt_s) {
  apply_user_motion();
  const Vec3 goal_solver = goal_solver_m();
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
  return end_tick(dt_s);
}

// The effects that can act in this tick, and their motion. The velocity of the device point in the
// scene is a backward difference: a medium then dissipates exactly b |dx|^2 / T in each tick.
void HapticLoop::begin_effects(double dt_s) {
  const Vec3 last_goal_m = std::exchange(last_goal_m_, vec3(record_.goal_scene_m));
  record_.effects = 0;
  tick_needs_ = kNeedsNothing;
  if (effects_->is_far_from_all(god_object_.world(), god_object_.proxy(), goal_solver_m())) return;
  tick_needs_ = world_->effects->needs & kTickNeeds;
  if (needs(kNeedsVelocity)) {
    velocity_m_per_s_.setZero();
    if (last_was_good_) velocity_m_per_s_ = (last_goal_m_ - last_goal_m) / dt_s;
  }
  motion_ = motion(dt_s);
  effects_->begin_tick();
}

void HapticLoop::end_effects() {
  record_.effects = effects_->end_tick();
  effects_->update_far_reach(god_object_.world(), god_object_.proxy(), touch_m());
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

// Action 3: the god-object follows the device point and stops at surfaces. At the first good
// sample, the god-object is placed at the device point.
inline void HapticLoop::detect_collision(double dt_s) {
  if (has_proxy_) {
    move_proxy(dt_s);
  } else {
    god_object_.place(goal_solver_m(), motion_plane_normal());
    proxy_state_ = {};
    proxy_state_.proxy = god_object_.proxy();
    has_proxy_ = true;
  }
  record_.contact = proxy_state_.in_contact;
  auto proxy_scene_m = view(record_.proxy_scene_m);
  proxy_scene_m = view(record_.goal_scene_m);
  if (proxy_state_.in_contact) proxy_scene_m = world_->to_scene(proxy_state_.proxy);
  record_.iterations = static_cast<std::uint32_t>(proxy_state_.iterations);
  record_.friction = proxy_state_.friction;
  if (proxy_state_.capped) record_.faults |= kFaultSolverCapped;
}

inline void HapticLoop::move_proxy(double dt_s) {
  const Vec3 goal_solver = goal_solver_m();
  if (strategy_) {
    const auto moved =
        strategy_->move_proxy(god_object_, goal_solver, motion_plane_normal(), strategy_tick(dt_s));
    if (moved) {
      proxy_state_ = *moved;
      return;
    }
  }
  if (!needs(kNeedsStickSlip)) {
    proxy_state_ = god_object_.move_to(goal_solver, motion_plane_normal());
    return;
  }
  ConesOfEffects cones(*effects_, god_object_.world());
  const FrictionSource source{cones, view(record_.device_m).lpNorm<1>() +
                                         view(record_.o_after_m).lpNorm<1>() +
                                         world_->anchor_scene_m.lpNorm<1>()};
  proxy_state_ = god_object_.move_with_friction(goal_solver, motion_plane_normal(), source);
}

// Action 4: the contact normal, which is the normalised average of the rendered normals in contact,
// and its angle to the actuated axes.
inline void HapticLoop::find_contact_normal() {
  view(record_.normal_scene).setZero();
  record_.alpha_rad = 0.0;
  normal_device_.setZero();
  if (needs(kNeedsContact)) {
    response_ = effects_->evaluate_contact(god_object_.contact(), proxy_state_, motion_);
  }
  if (!record_.contact) return;
  const Vec3& normal_scene = needs(kNeedsContact) ? response_.normal : proxy_state_.normal;
  view(record_.normal_scene) = normal_scene;
  if (normal_scene.isZero(0.0)) return;  // opposite planes cancel: no direction to align
  normal_device_ = R_device_scene_ * normal_scene;
  record_.alpha_rad = actuation_.angle_to_actuated_rad(normal_device_);
}

inline void HapticLoop::render_force(double dt_s) {
  Vec3 force_N = Vec3::Zero();  // solver axes
  if (record_.contact) {
    force_N = contact_force_N(dt_s);
  } else {
    coupling_.reset();
    if (!needs(kNeedsSurroundings)) return set_zero_force();
  }
  if (needs(kNeedsSurroundings)) {
    force_N += effects_->surroundings_force_N(god_object_.world(), proxy_state_,
                                              view(record_.normal_scene), motion_);
    if (effects_->is_capped()) record_.faults |= kFaultEffectsCapped;
  }
  command(force_N, dt_s);
}

inline Vec3 HapticLoop::contact_force_N(double dt_s) {
  const Vec3 lag = proxy_state_.proxy - goal_solver_m();
  const Vec3 rate = coupling_.lag_rate_m_per_s(lag, dt_s);
  if (has_effects_in_contact()) {
    // The damper acts on the whole lag of a proxy at rest. A sliding proxy yields along the
    // surface.
    const bool rests = proxy_state_.is_held && !proxy_state_.slid;
    const Vec3 damped = rests ? rate : proxy_state_.pressed_part(rate);
    coupling_force_N_ = rendered_force_N(response_, proxy_state_, lag, damped);
    return coupling_force_N_ + effects_->contact_force_N(proxy_state_, response_, motion_);
  }
  coupling_force_N_ =
      coupling_.force_N(lag, proxy_state_.pressed_part(rate), view(record_.normal_scene));
  return coupling_force_N_;
}

inline void HapticLoop::command(const Vec3& force_N, double dt_s) {
  if (!std::isfinite(force_N.sum())) return refuse_force();
  if (strategy_) {
    if (const auto force = strategy_->force(force_N, strategy_tick(dt_s))) {
      view(record_.full_force_device_N) = force->full_N;
      view(record_.force_device_N) = force->commanded_N;
      return;
    }
  }
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

void HapticLoop::place_scene(const ScenePose& T_device_scene) {
  put(T_device_scene, record_.q_after_wxyz, record_.o_after_m);
  R_device_scene_ = T_device_scene.rotation.toRotationMatrix();
}

// Action 5: Table 1. No rotation off contact.
inline AxisAngle HapticLoop::find_theoretical_rotation() {
  if (!record_.contact) theoretical_rotation_.reset();
  if (!record_.contact || !settings_.a4.enabled) return {};
  return theoretical_rotation_.update(normal_device_);
}

// Action 6: Figure 3. The pivot is the proxy, so the proxy stays feasible and the spring gains no
// energy.
inline void HapticLoop::apply_elementary_rotation(const AxisAngle& theoretical, double dt_s) {
  record_.rotation_rad = 0.0;
  if (theoretical.angle_rad == 0.0) return;
  const double angle_rad =
      elementary_rotation_rad(settings_.a4.profile, settings_.a4.step, theoretical.angle_rad, dt_s);
  const ScenePose turned = turned_about(T_device_scene(), view(record_.proxy_scene_m),
                                        {theoretical.axis_device, angle_rad});
  record_.rotation_rad = angle_rad;
  place_scene(turned);
}

// The record still holds the forces and the contact of the last tick.
void HapticLoop::place_scene_by_strategy(double dt_s) {
  const auto origin_m = strategy_->scene_origin_m(strategy_tick(dt_s));
  if (!origin_m) return;
  place_scene({T_device_scene().rotation, *origin_m});
  view(record_.o_before_m) = *origin_m;  // the pose during this tick
}

void HapticLoop::turn_scene_by_strategy(double dt_s) {
  const AxisAngle turn = strategy_->turn_about_device_point(strategy_tick(dt_s));
  if (turn.angle_rad == 0.0) return;
  record_.rotation_rad = turn.angle_rad;
  place_scene(
      turned_about(T_device_scene(), view(record_.goal_scene_m), view(record_.device_m), turn));
}

StrategyTick HapticLoop::strategy_tick(double dt_s) const {
  return {.record = record_,
          .actuation = actuation_,
          .settings = settings_,
          .world = god_object_.world(),
          .R_device_scene = R_device_scene_,
          .proxy = proxy_state_,
          .contact = god_object_.contact(),
          .goal_solver_m = goal_solver_m(),
          .response = has_effects_in_contact() ? &response_ : nullptr,
          .coupling_force_N = coupling_force_N_,
          .radius_m = god_object_.radius_m(),
          .dt_s = dt_s,
          .follows_good_tick = last_was_good_};
}

}  // namespace palpate
