#pragma once

// Actions 2 to 6 of a tick, as templates for the files that compile them with and without effects.
// Each union of needs has its own instance: in a world without effects, no instruction that serves
// an effect is executed.

#include "haptics/effects/rendered_force.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"

namespace palpate {

// Not a need of an effect: the proxy rests in the norm of W (strategies/anisotropic.h).
inline constexpr std::uint32_t kInAnisotropicNorm = 1u << 31;
inline constexpr std::uint32_t kEffectNeeds = ~kInAnisotropicNorm;

// Provides the god-object with the friction coefficients that a world's effects set for its faces.
class ConesOfEffects final : public FrictionCones {
 public:
  ConesOfEffects(EffectRunner& effects, const LiveWorld& world)
      : effects_(effects), world_(world) {}
  FrictionCone at(const FaceContact& contact, const Vec3& proxy) noexcept override {
    return effects_.friction_cone(world_, contact, proxy);
  }

 private:
  EffectRunner& effects_;
  const LiveWorld& world_;
};

template <std::uint32_t kNeeds>
void HapticLoop::step(double dt_s) {
  if constexpr ((kNeeds & kEffectNeeds) == kNeedsNothing) {
    apply_user_motion();  // action 2
    run_actions<kNeeds>(dt_s);
  } else {
    const Vec3 last_goal_m = view(record_.goal_scene_m);
    apply_user_motion();
    record_.effects = 0;
    const Vec3 goal_solver = world_->to_solver(view(record_.goal_scene_m));
    if (effects_->is_far_from_all(god_object_.world(), god_object_.proxy(), goal_solver))
      return (this->*step_without_effects_)(dt_s);
    if constexpr ((kNeeds & kNeedsVelocity) != 0) find_velocity(last_goal_m, dt_s);
    run_actions<kNeeds>(dt_s);
    effects_->update_far_reach(god_object_.world(), god_object_.proxy(), touch_m());
  }
}

template <std::uint32_t kNeeds>
void HapticLoop::run_actions(double dt_s) {
  if constexpr ((kNeeds & kEffectNeeds) != kNeedsNothing) motion_ = motion(dt_s);
  detect_collision<kNeeds>();     // action 3
  find_contact_normal<kNeeds>();  // action 4
  render_force<kNeeds>(dt_s);
  const AxisAngle theoretical = find_theoretical_rotation();  // action 5
  apply_elementary_rotation(theoretical, dt_s);               // action 6
}

// Action 3: the god-object follows the device point and stops at surfaces. At the first good
// sample, the god-object is placed at the device point.
template <std::uint32_t kNeeds>
inline void HapticLoop::detect_collision() {
  const Vec3 goal_solver = world_->to_solver(view(record_.goal_scene_m));
  if constexpr ((kNeeds & kEffectNeeds) != kNeedsNothing) effects_->begin_tick();
  if (!has_proxy_) {
    god_object_.place(goal_solver, motion_plane_normal());
    proxy_state_ = {};
    proxy_state_.proxy = god_object_.proxy();
    has_proxy_ = true;
  } else if constexpr ((kNeeds & kInAnisotropicNorm) != 0) {
    move_proxy_in_norm(goal_solver);
  } else if constexpr ((kNeeds & kNeedsStickSlip) != 0) {
    ConesOfEffects cones(*effects_, god_object_.world());
    const FrictionSource source{cones, view(record_.device_m).lpNorm<1>() +
                                           view(record_.o_after_m).lpNorm<1>() +
                                           world_->anchor_scene_m.lpNorm<1>()};
    proxy_state_ = god_object_.move_with_friction(goal_solver, motion_plane_normal(), source);
  } else {
    proxy_state_ = god_object_.move_to(goal_solver, motion_plane_normal());
  }
  record_.contact = proxy_state_.in_contact;
  auto proxy_scene_m = view(record_.proxy_scene_m);
  proxy_scene_m = view(record_.goal_scene_m);
  if (proxy_state_.in_contact) proxy_scene_m = world_->to_scene(proxy_state_.proxy);
  record_.iterations = static_cast<std::uint32_t>(proxy_state_.iterations);
  record_.friction = proxy_state_.friction;
  if (proxy_state_.capped) record_.faults |= kFaultSolverCapped;
}

// Action 4: the contact normal, which is the normalised average of the rendered normals in contact,
// and its angle to the actuated axes.
template <std::uint32_t kNeeds>
void HapticLoop::find_contact_normal() {
  view(record_.normal_scene).setZero();
  record_.alpha_rad = 0.0;
  normal_device_.setZero();
  if constexpr ((kNeeds & kNeedsContact) != 0) {
    response_ = effects_->evaluate_contact(god_object_.contact(), proxy_state_, motion_);
  }
  if (!record_.contact) return;
  const Vec3* normal_scene = &proxy_state_.normal;
  if constexpr ((kNeeds & kNeedsContact) != 0) normal_scene = &response_.normal;
  view(record_.normal_scene) = *normal_scene;
  if (normal_scene->isZero(0.0)) return;  // opposite planes cancel: no direction to align
  normal_device_ = R_device_scene_ * *normal_scene;
  record_.alpha_rad = actuation_.angle_to_actuated_rad(normal_device_);
}

template <std::uint32_t kNeeds>
void HapticLoop::render_force(double dt_s) {
  Vec3 force_N = Vec3::Zero();  // solver axes
  if (record_.contact) {
    force_N = contact_force_N<kNeeds>(dt_s);
  } else {
    coupling_.reset();
    if constexpr ((kNeeds & kNeedsSurroundings) == 0) {
      set_zero_force();
      if constexpr ((kNeeds & kEffectNeeds) != kNeedsNothing) {
        record_.effects = effects_->end_tick();
      }
      return;
    }
  }
  if constexpr ((kNeeds & kNeedsSurroundings) != 0) {
    force_N += effects_->surroundings_force_N(god_object_.world(), proxy_state_,
                                              view(record_.normal_scene), motion_);
    if (effects_->is_capped()) record_.faults |= kFaultEffectsCapped;
  }
  if constexpr ((kNeeds & kEffectNeeds) != kNeedsNothing) record_.effects = effects_->end_tick();
  if constexpr ((kNeeds & kInAnisotropicNorm) != 0) return command_in_norm(force_N);
  command(force_N);
}

template <std::uint32_t kNeeds>
Vec3 HapticLoop::contact_force_N(double dt_s) {
  const Vec3 lag = proxy_state_.proxy - world_->to_solver(view(record_.goal_scene_m));
  const Vec3 rate = coupling_.lag_rate_m_per_s(lag, dt_s);
  if constexpr ((kNeeds & kNeedsContact) != 0) {
    if (!response_.without_effects) {
      // The damper acts on the whole lag of a proxy at rest. A sliding proxy yields along the
      // surface.
      const bool rests = proxy_state_.is_held && !proxy_state_.slid;
      const Vec3 damped = rests ? rate : proxy_state_.pressed_part(rate);
      return rendered_force_N(response_, proxy_state_, lag, damped) +
             effects_->contact_force_N(proxy_state_, response_, motion_);
    }
  }
  return coupling_.force_N(lag, proxy_state_.pressed_part(rate), view(record_.normal_scene));
}

}  // namespace palpate
