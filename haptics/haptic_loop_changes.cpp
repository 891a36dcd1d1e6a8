// What a loop's owner changes between ticks, and the ticks of a free hand.

#include <algorithm>
#include <utility>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"

namespace palpate {

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

RigidTransform HapticLoop::T_scene_body(std::uint32_t body) const noexcept {
  const RigidTransform& T_solver_body = god_object_.world().body(body).T_solver_body;
  return {T_solver_body.rotation, world_->to_scene(T_solver_body.translation_m)};
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

void HapticLoop::set_coupling(double stiffness_N_per_m, double damping_Ns_per_m) noexcept {
  settings_.coupling.stiffness_N_per_m = stiffness_N_per_m;
  settings_.coupling.damping_Ns_per_m = damping_Ns_per_m;
  coupling_.set(stiffness_N_per_m, damping_Ns_per_m);
  if (effects_) effects_->set_coupling(stiffness_N_per_m, damping_Ns_per_m);
}

void HapticLoop::free_hand() noexcept {
  is_hand_free_ = true;
  has_proxy_ = false;
}

// Strategies and effects begin as in a first tick.
void HapticLoop::hold_hand() noexcept {
  if (!is_hand_free_) return;
  is_hand_free_ = false;
  last_was_good_ = false;
  end_contact_force();
  if (effects_) effects_->reset_states();
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

}  // namespace palpate
