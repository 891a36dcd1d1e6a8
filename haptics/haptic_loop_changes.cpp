// What a loop's owner changes between ticks.

#include "haptics/haptic_loop.h"

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

CountedSpring HapticLoop::counted_spring(const Vec3& lag_m) const {
  return strategy_ ? strategy_->counted_spring(lag_m, strategy_tick(last_dt_s_))
                   : CountedSpring{1.0, lag_m.norm()};
}

ForceSources HapticLoop::force_sources() const noexcept {
  ForceSources sources;
  const bool acts =
      tick_needs_ != kNeedsNothing && !is_hand_free_ && (record_.faults & kFaultsWithoutForce) == 0;
  if (record_.contact != 0) {
    const bool has_response = acts && needs(kNeedsContact) && !response_.without_effects;
    sources.stiffness_N_per_m =
        has_response ? response_.coupling.stiffness_N_per_m : settings_.coupling.stiffness_N_per_m;
    const CountedSpring spring =
        counted_spring(vec3(record_.proxy_scene_m) - vec3(record_.goal_scene_m));
    sources.stiffness_N_per_m *= spring.stiffness_factor;
    sources.lag_m = spring.lag_m;
  }
  if (bodies_moved_) {
    sources.nodes_moved = true;
    sources.nodes_J = 0.5 * sources.stiffness_N_per_m * bodies_stretched_m2_;
  }
  if (acts && effects_->has_giving_forces()) {
    sources.has_effects = true;
    const GivingForces& giving = effects_->giving_forces();
    for (std::size_t n = 0; n < giving.size(); ++n) {
      sources.effects_N[n] = R_device_scene_ * giving[n];
    }
  }
  return sources;
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

}  // namespace palpate
