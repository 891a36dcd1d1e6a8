// The god-object under friction: see GodObject::move_with_friction().

#include <algorithm>
#include <array>
#include <limits>

#include "haptics/proxy/god_object_escapes.h"

namespace palpate {
namespace {

// Largest difference, (1 + mu) times this for coordinates of size 1, between a tangential lag and
// mu times the depth that count as equal. Lag and depth are differences of coordinates. Each
// coordinate is rounded several times by half an ulp: in the device sample, which its source
// computed from other numbers (8 times); in the goal, which the loop computes from the sample by a
// rotation and two translations (8); in the sample and goal of the tick that determined the proxy
// (16); in the proxy (2); in a height above a face (kHeightRoundoff, 60); in the transformation of
// the proxy to a frame and back (16); and in a projection (8). These 118 roundings of a coordinate
// are 205 of a vector; with the rounding of lengths and products, at most 256.
constexpr double kConeRoundoff = 128 * std::numeric_limits<double>::epsilon();

// The friction policy of GodObject::move_with_friction(): the state of friction in one tick.
struct CoulombFriction : EuclideanNorm {
  static constexpr bool kHolds = true;

  const FrictionSource* source;
  double coordinates_m;    // size of the coordinates that this tick computes with
  bool slides;             // the contact slides, from an earlier tick or a step of this tick
  FrictionCone cone = {};  // weighted sum over the planes of the last step
  std::array<bool, 3> holds_by = {};  // which of these planes have friction
  double rounding_m = 0.0;            // rounding of lag and depth in the last step
  bool is_below_cone = false;         // the lag of the last step was below the dynamic cone
  bool wants_to_slide = false;        // the last step exceeded the cone
  bool slid = false;                  // a step of this tick slid

  // Whether the faces of the last step have friction, and whether a given face has.
  bool holds() const { return cone.holds(); }
  bool may_hold_at(const FaceContact& contact, const Vec3& proxy) const {
    return source->cones.at(contact, proxy).holds();
  }

  // moved: the step changed the position. A proxy that exceeded the cone but could not move keeps
  // its state.
  void end_step(bool moved) {
    slides = slides || (wants_to_slide && moved);
    slid = slid || (wants_to_slide && moved);
    wants_to_slide = false;
  }

  // Resets the state before the cones of a step are queried.
  void begin_step() {
    cone = {};
    holds_by = {};
    is_below_cone = false;
    wants_to_slide = false;
  }

  // Whether the contact slides after the tick. A contact that has slid continues to slide even if
  // planes met on the path would hold it now; the next tick decides whether it sticks there.
  bool slides_on() const { return slides && !is_below_cone; }

  ProxyState complete(ProxyState state) const {
    // A proxy whose tick was capped between two faces keeps its earlier state.
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

  // The fraction of a step that friction permits, in [0, 1]. lag_m: length of the step. depth_m:
  // distance from its end to the goal.
  double part_left(double lag_m, double depth_m) {
    const double dynamic_m = cone.dynamic_friction * depth_m;
    const double mu = slides ? cone.dynamic_friction : cone.static_friction;
    wants_to_slide = lag_m > mu * depth_m + (1.0 + mu) * rounding_m;
    is_below_cone = lag_m < dynamic_m - (1.0 + cone.dynamic_friction) * rounding_m;
    return wants_to_slide ? std::max(0.0, 1.0 - dynamic_m / lag_m) : 0.0;
  }
};

}  // namespace

// Shortens the step to the part that friction permits. False if the active planes have no friction.
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

// Whether friction holds the proxy at its position after the last tick. If so, no search is needed,
// and the position stays the same bit for bit.
template <typename Friction>
bool GodObject::stays_at_rest(Friction& friction) {
  if (!confirmed_ || !has_friction() || plane_count_ < last_active_count_) return false;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved || !hold_by(friction)) return false;
  if (!projection_.displacement_m.isZero(0.0)) return false;
  if (leaves_edges(Progress::kHeld, friction) || rounding_decides_) return false;
  if (tracer_.is_cut_short()) return false;  // not all attempts have been made
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
  CoulombFriction friction{{}, &source, coordinates_m, slides_};
  const ProxyState state = move(goal, motion_plane_normal, friction);
  last_holds_ = state.is_held ? friction.holds_by : std::array<bool, 3>{};
  slides_ = state.in_contact && friction.slides_on();
  return state;
}

}  // namespace palpate
