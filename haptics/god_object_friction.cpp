// The god-object under friction: see GodObject::move_with_friction().

#include <algorithm>
#include <array>
#include <limits>

#include "haptics/god_object_steps.h"

namespace palpate {
namespace {

// A lag within so much of the cone's, relative, is on the cone: rounding of the step that ended
// there.
constexpr double kOnCone = 64 * std::numeric_limits<double>::epsilon();

// What the steps of one tick have met.
struct CoulombFriction {
  static constexpr bool kHolds = true;

  const FrictionSource* source;
  FrictionCone cone = {};          // of the last step's planes
  std::array<bool, 3> holds = {};  // which of these planes do
  bool slides = false;             // the step that was shortened last
  bool slid = false;               // an earlier one
  bool is_on_cone = false;

  // moved: the step led anywhere. A proxy that was to slide and cannot is at rest.
  void end_step(bool moved) {
    slid = slid || (slides && moved);
    is_on_cone = is_on_cone || (slides && moved);
    slides = false;
  }

  ProxyState complete(ProxyState state) const {
    if (!state.in_contact || state.active_planes == 0 || !cone.holds()) return state;
    state.is_held = true;
    state.slid = slid;
    state.is_on_cone = is_on_cone;
    state.cone = cone;
    return state;
  }

  // The part of a step that friction leaves, [0, 1]. lag_m: the length of the step. depth_m: from
  // its end to the goal.
  double part_left(double lag_m, double depth_m) {
    const double dynamic_m = cone.dynamic_friction * depth_m;
    const double hold_m = slid ? dynamic_m : cone.static_friction * depth_m;
    slides = lag_m > hold_m;
    is_on_cone = slid && lag_m >= (1.0 - kOnCone) * dynamic_m;
    return slides ? std::max(0.0, 1.0 - dynamic_m / lag_m) : 0.0;
  }
};

}  // namespace

// Shortens the step to what friction leaves of it. False if what is touched has none.
template <typename Friction>
bool GodObject::hold_by(Friction& friction) {
  friction.cone = {};
  friction.holds = {};
  friction.slides = false;
  if (projection_.active_count == 0) return false;
  Vec3& step = projection_.displacement_m;
  const Vec3 lag = proxy_ + step - goal_;
  const auto count = static_cast<std::size_t>(projection_.active_count);
  std::array<Vec3, 3> normals;
  for (std::size_t i = 0; i < count; ++i) normals[i] = plane_normal(i);
  const auto parts = bearing_parts(lag, std::span(normals).first(count));
  const double depth_m = lag.norm();
  for (std::size_t i = 0; i < count; ++i) {
    const FrictionCone cone = friction.source->cone(
        friction.source->context, contacts_[projection_.active[static_cast<int>(i)]], proxy_);
    friction.holds[i] = cone.holds();
    const double part = depth_m > 0.0 ? parts[i] / depth_m : 0.0;
    friction.cone.static_friction += part * cone.static_friction;
    friction.cone.dynamic_friction += part * cone.dynamic_friction;
  }
  if (!friction.cone.holds()) return false;
  step *= friction.part_left(step.norm(), depth_m);
  return true;
}

// Whether friction holds a proxy where the last tick left it: then there is nothing to look for,
// and it keeps its place to the bit.
template <typename Friction>
bool GodObject::stays_at_rest(Friction& friction) {
  if (!confirmed_ || !has_friction() || plane_count_ < last_active_count_) return false;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved || !hold_by(friction)) return false;
  if (!projection_.displacement_m.isZero(0.0)) return false;
  keep_contacts_for_next_tick(false);
  return true;
}

ProxyState GodObject::move_with_friction(const Vec3& goal,
                                         const std::optional<Vec3>& motion_plane_normal,
                                         const FrictionSource& source) noexcept {
  if (!is_goal(goal, motion_plane_normal)) return refused();
  CoulombFriction friction{&source};
  const ProxyState state = move(goal, motion_plane_normal, friction);
  last_holds_ = state.is_held ? friction.holds : std::array<bool, 3>{};
  return state;
}

}  // namespace palpate
