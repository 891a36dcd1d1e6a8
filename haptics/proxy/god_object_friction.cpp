// The god-object under friction: see GodObject::move_with_friction().

#include <algorithm>
#include <array>
#include <limits>

#include "haptics/proxy/god_object_ways.h"

namespace palpate {
namespace {

// How far a tangential lag may be from mu times the depth and count as equal: (1 + mu) times this,
// for coordinates of size 1. Lag and depth are differences of coordinates, each rounded by half an
// ulp at a time: the sample, which somebody made from others (8 times), the goal, which the loop
// makes of it by a turn and two shifts (8), both likewise in the tick that put the proxy where it
// is (16), the proxy itself (2), a height above a face (kHeightRoundoff, 60), a frame to which the
// proxy is brought and from which it is brought back (16), a projection (8). 118 of a coordinate
// are 205 of a vector; with what lengths and products lose, no more than 256.
constexpr double kConeRoundoff = 128 * std::numeric_limits<double>::epsilon();

// What the steps of one tick have met.
struct CoulombFriction {
  static constexpr bool kHolds = true;

  const FrictionSource* source;
  double coordinates_m;    // the size of all that a tick goes by
  bool slides;             // the contact: from an earlier tick, or since a step of this one
  FrictionCone cone = {};  // of the last step's planes
  std::array<bool, 3> holds_by = {};  // which of these planes do
  double rounding_m = 0.0;            // of lags and depths in the last step
  bool is_below_cone = false;         // its lag
  bool wants_to_slide = false;        // the step that was shortened last
  bool slid = false;                  // a step of this tick

  // What the last step touched, and what the proxy may touch there.
  bool holds() const { return cone.holds(); }
  bool may_hold_at(const FaceContact& contact, const Vec3& proxy) const {
    return source->cones.at(contact, proxy).holds();
  }

  // moved: the step led anywhere. A proxy that was to slide and cannot keeps its state.
  void end_step(bool moved) {
    slides = slides || (wants_to_slide && moved);
    slid = slid || (wants_to_slide && moved);
    wants_to_slide = false;
  }

  // Before planes are asked for their cones.
  void begin_step() {
    cone = {};
    holds_by = {};
    is_below_cone = false;
    wants_to_slide = false;
  }

  // Of the contact, after the tick. One that has slid goes on, though planes that it met on the way
  // may hold it now: whether it sticks there is for the next tick.
  bool slides_on() const { return slides && (slid || !is_below_cone); }

  ProxyState complete(ProxyState state) const {
    // Cut short between two faces, it has its state from before.
    if (state.in_contact && state.active_planes == 0 && slides) {
      state.friction = FrictionState::kSlides;
    }
    if (!state.in_contact || state.active_planes == 0 || !cone.holds()) return state;
    state.is_held = true;
    state.slid = slid;
    state.friction = slides_on() ? FrictionState::kSlides : FrictionState::kSticks;
    state.cone = cone;
    return state;
  }

  // The part of a step that friction leaves, [0, 1]. lag_m: the length of the step. depth_m: from
  // its end to the goal.
  double part_left(double lag_m, double depth_m) {
    const double dynamic_m = cone.dynamic_friction * depth_m;
    const double mu = slides ? cone.dynamic_friction : cone.static_friction;
    wants_to_slide = lag_m > mu * depth_m + (1.0 + mu) * rounding_m;
    is_below_cone = lag_m < dynamic_m - (1.0 + cone.dynamic_friction) * rounding_m;
    return wants_to_slide ? std::max(0.0, 1.0 - dynamic_m / lag_m) : 0.0;
  }
};

}  // namespace

// Shortens the step to what friction leaves of it. False if what is touched has none.
template <typename Friction>
bool GodObject::hold_by(Friction& friction) {
  friction.begin_step();
  if (projection_.active_count == 0) return false;
  Vec3& step = projection_.displacement_m;
  const Vec3 lag = proxy_ + step - goal_;
  const auto count = static_cast<std::size_t>(projection_.active_count);
  std::array<Vec3, 3> normals;
  for (std::size_t i = 0; i < count; ++i) normals[i] = plane_normal(i);
  const auto parts = bearing_parts(lag, std::span(normals).first(count));
  const double depth_m = lag.norm();
  double farthest_body_m = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const FaceContact& contact = contacts_[projection_.active[static_cast<int>(i)]];
    const FrictionCone cone = friction.source->cones.at(contact, proxy_);
    friction.holds_by[i] = cone.holds();
    const double part = depth_m > 0.0 ? parts[i] / depth_m : 0.0;
    friction.cone.static_friction += part * cone.static_friction;
    friction.cone.dynamic_friction += part * cone.dynamic_friction;
    farthest_body_m = std::max(
        farthest_body_m, world_->body(contact.face.body).T_solver_body.translation_m.lpNorm<1>());
  }
  friction.rounding_m = kConeRoundoff * (friction.coordinates_m + farthest_body_m);
  if (!friction.cone.holds()) {
    friction.wants_to_slide = step.norm() > friction.rounding_m;
    return false;
  }
  step *= friction.part_left(step.norm(), depth_m);
  return true;
}

// Whether friction holds a proxy where the last tick left it: then there is nothing more to look
// for, and it keeps its place to the bit.
template <typename Friction>
bool GodObject::stays_at_rest(Friction& friction) {
  if (!confirmed_ || !has_friction() || plane_count_ < last_active_count_) return false;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved || !hold_by(friction)) return false;
  if (!projection_.displacement_m.isZero(0.0)) return false;
  if (leaves_edges(Progress::kHeld, friction) || rounding_decides_) return false;
  if (tracer_.is_cut_short()) return false;  // not all ways have been tried
  goes_on_ = goal_waits_;
  keep_contacts_for_next_tick(false);
  return true;
}

ProxyState GodObject::move_with_friction(const Vec3& goal,
                                         const std::optional<Vec3>& motion_plane_normal,
                                         const FrictionSource& source) noexcept {
  const bool is_source = std::isfinite(source.coordinates_m) && source.coordinates_m >= 0.0;
  if (!is_source || !is_goal(goal, motion_plane_normal)) return refused();
  const double coordinates_m = world_->size_m() + settings_.radius_m + proxy_.lpNorm<1>() +
                               goal.lpNorm<1>() + source.coordinates_m;
  CoulombFriction friction{&source, coordinates_m, slides_};
  const ProxyState state = move(goal, motion_plane_normal, friction);
  last_holds_ = state.is_held ? friction.holds_by : std::array<bool, 3>{};
  slides_ = state.in_contact && friction.slides_on();
  return state;
}

}  // namespace palpate
