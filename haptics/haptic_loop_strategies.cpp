// The steps of loops with a strategy that force and A4 do not describe.

#include "haptics/haptic_loop_strategies.h"

#include <cmath>

#include "haptics/haptic_loop_steps.h"
#include "haptics/record_vectors.h"
#include "haptics/strategies/anisotropic.h"

namespace palpate {

// The scope of `anisotropic` leaves one need of effects: that of stiffness and damping.
void HapticLoop::use_strategy() {
  strategy_ = std::make_unique<StrategyState>();
  strategy_->inner = step_;
  switch (settings_.strategy->kind) {
    case StrategyKind::kA4Anticipate:
      strategy_->window.set_window(A4Anticipation::kWindow_s);
      strategy_->anticipation.emplace(actuation_, settings_.a4, settings_.anticipation);
      step_ = &HapticLoop::step_anticipating;
      return;
    case StrategyKind::kAnisotropic:
      step_ = effects_ ? &HapticLoop::step<kInAnisotropicNorm | kNeedsContact>
                       : &HapticLoop::step<kInAnisotropicNorm>;
      step_without_effects_ = &HapticLoop::run_actions<kInAnisotropicNorm>;
      return;
    case StrategyKind::kControlDisplay:
      strategy_->home_m = view(record_.o_after_m);
      step_ = &HapticLoop::step_following;
      return;
    default:
      return;  // check_settings() has refused it
  }
}

// Actions 2 to 6, and in free motion the rotation before a touch.
void HapticLoop::step_anticipating(double dt_s) {
  StrategyState& state = *strategy_;
  (this->*state.inner)(dt_s);
  if (!last_was_good_) state.window.clear();
  state.window.add(record_.time_s, view(record_.device_m));
  if (record_.contact) return state.anticipation->end();
  anticipate(dt_s);
}

void HapticLoop::anticipate(double dt_s) {
  const Accuracy& accuracy = settings_.god_object.accuracy;
  const AxisAngle turn = strategy_->anticipation->update(
      {god_object_.world(), actuation_, world_->to_solver(view(record_.goal_scene_m)),
       R_device_scene_, strategy_->window.velocity_m_per_s(), god_object_.radius_m(), dt_s,
       accuracy.work_budget - proxy_state_.work, accuracy.counting});
  if (turn.angle_rad == 0.0) return;
  record_.rotation_rad = turn.angle_rad;
  place_scene(
      turned_about(T_device_scene(), view(record_.goal_scene_m), view(record_.device_m), turn));
}

// Actions 2 to 6, after the scene has followed a part of the hand's step.
void HapticLoop::step_following(double dt_s) {
  StrategyState& state = *strategy_;
  if (last_was_good_) follow_hand();
  state.last_device_m = view(record_.device_m);
  (this->*state.inner)(dt_s);
}

// The record still holds the forces and the contact of the last tick.
void HapticLoop::follow_hand() {
  StrategyState& state = *strategy_;
  const Vec3 lag_scene_m = view(record_.proxy_scene_m) - view(record_.goal_scene_m);
  state.control_display.update({view(record_.device_m) - state.last_device_m, record_.contact != 0,
                                R_device_scene_ * lag_scene_m,
                                view(record_.full_force_device_N) - view(record_.force_device_N)});
  const Vec3 origin_m = state.home_m + state.control_display.drift_m();
  place_scene({T_device_scene().rotation, origin_m});
  view(record_.o_before_m) = origin_m;  // the pose during this tick
}

void HapticLoop::move_proxy_in_norm(const Vec3& goal_solver) {
  const AnisotropicNorm norm =
      anisotropic_norm(settings_.strategy->anisotropy, actuation_, R_device_scene_);
  proxy_state_ = norm.is_euclidean()
                     ? god_object_.move_to(goal_solver, motion_plane_normal())
                     : god_object_.move_in_norm(goal_solver, motion_plane_normal(), norm);
}

void HapticLoop::command_in_norm(const Vec3& force_N) {
  if (!std::isfinite(force_N.sum())) return refuse_force();
  const Vec3 force_device_N = R_device_scene_ * force_N;
  view(record_.full_force_device_N) = R_device_scene_ * proxy_state_.pressed_part(force_N);
  view(record_.force_device_N) = actuation_.actuated_part(force_device_N);
}

}  // namespace palpate
