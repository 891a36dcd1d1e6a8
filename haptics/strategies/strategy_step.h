#pragma once

// What a strategy does in the ticks of a loop, beyond the force mode and A4: the places of
// HapticLoop::tick at which it enters.

#include <optional>

#include "haptics/a4/actuation.h"
#include "haptics/a4/theoretical_rotation.h"
#include "haptics/effects/effect_runner.h"
#include "haptics/proxy/god_object.h"
#include "haptics/proxy/proxy_state.h"
#include "haptics/strategies/haptic_settings.h"
#include "palpate/record.h"

namespace palpate {

// The state of the loop that calls a strategy.
struct StrategyTick {
  const TickRecord& record;
  const ActuationModel& actuation;
  const HapticSettings& settings;
  const LiveWorld& world;
  const Mat3& R_device_scene;  // from solver axes to the device frame
  const ProxyState& proxy;     // of this tick; in scene_origin_m() of the last one
  ContactView contact;         // of the same tick as the proxy
  Vec3 goal_solver_m;          // the device point; in scene_origin_m() of the last tick
  // How effects render the contact; null: as the coupling of the settings does. From force() on.
  const ContactResponse* response;
  Vec3 coupling_force_N;  // of spring, damper and friction, solver axes; from force() on
  double radius_m;
  double dt_s;
  bool follows_good_tick;  // the last tick had a good sample and a hand that was not free
};

// The force of a tick, device frame.
struct StrategyForce {
  Vec3 full_N;       // TickRecord::full_force_device_N
  Vec3 commanded_N;  // TickRecord::force_device_N
};

// The spring of a contact, as the safety governor counts it: an isotropic one that stores the same
// energy, and whose lag grows by no more than the way of the hand while the scene is fixed.
struct CountedSpring {
  double stiffness_factor = 1.0;  // of the coupling's stiffness
  double lag_m = 0.0;
};

// Each loop has its own object. The functions are called in ticks with a good sample and a hand
// that is not free, in the order below; one that is not overridden leaves the tick as it is without
// a strategy. Safe on the haptic thread: no allocation, lock or exception after construction.
class StrategyStep {
 public:
  virtual ~StrategyStep() = default;

  // Before action 2: the origin of the scene in this tick, device frame, m; no value: where it is.
  // The record has the device position of this tick, and contact, points and forces of the last.
  virtual std::optional<Vec3> scene_origin_m(const StrategyTick&) noexcept { return std::nullopt; }

  // Action 3: moves the proxy towards a goal (solver frame, m); no value: it has not, and the loop
  // moves the proxy as without a strategy.
  virtual std::optional<ProxyState> move_proxy(GodObject& /*god_object*/,
                                               const Vec3& /*goal_solver_m*/,
                                               const std::optional<Vec3>& /*motion_plane_normal*/,
                                               const StrategyTick&) noexcept {
    return std::nullopt;
  }

  // The force that is recorded and commanded for the force of the contact and the effects (solver
  // axes, finite); no value: as the force mode states.
  virtual std::optional<StrategyForce> force(const Vec3& /*force_N*/,
                                             const StrategyTick&) noexcept {
    return std::nullopt;
  }

  // lag_m: from the device point to the proxy, solver axes. Between ticks, too.
  virtual CountedSpring counted_spring(const Vec3& lag_m, const StrategyTick&) const noexcept {
    return {1.0, lag_m.norm()};
  }

  // After action 6, with the pose after A4's turn: a further rotation of the scene, about the
  // device point; its angle is 0 for none.
  virtual AxisAngle turn_about_device_point(const StrategyTick&) noexcept { return {}; }
};

}  // namespace palpate
