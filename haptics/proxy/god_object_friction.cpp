// The god-object under friction: see GodObject::move_with_friction().

#include <algorithm>
#include <array>
#include <cmath>
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

// Largest number of places at which the search for the end of a slide evaluates the friction.
// Coefficients that vary smoothly need about six; bisection alone halves the slide to its last bit.
constexpr int kMostPlacesOnASlide = 60;

// The part of a slide, in [0, 1], at which the lag has fallen to the cone. excess_m: the lag minus
// the limit of the cone at a part of the slide; positive at 0, not positive at 1. The search is a
// regula falsi that halves the weight of an end that stays (the Illinois algorithm), with every
// third step a bisection. It ends within tolerance_m of the cone, or below the cone if a jump of
// the coefficients hides it.
template <typename Excess>
double part_to_cone(const Excess& excess_m, double tolerance_m) {
  double low = 0.0;
  double high = 1.0;
  double low_m = excess_m(low);
  double high_m = excess_m(high);
  if (high_m >= -tolerance_m) return high;
  int in_a_row = 0;  // how often the same end has moved: the lower (positive), the upper (negative)
  for (int i = 0; i < kMostPlacesOnASlide; ++i) {
    const double part =
        i % 3 == 2 ? 0.5 * (low + high) : low + low_m / (low_m - high_m) * (high - low);
    if (!(part > low && part < high)) break;
    const double at_m = excess_m(part);
    if (std::abs(at_m) <= tolerance_m) return part;
    in_a_row = at_m > 0.0 ? std::max(in_a_row, 0) + 1 : std::min(in_a_row, 0) - 1;
    if (in_a_row > 1) high_m *= 0.5;
    if (in_a_row < -1) low_m *= 0.5;
    (at_m > 0.0 ? low : high) = part;
    (at_m > 0.0 ? low_m : high_m) = at_m;
  }
  return high;
}

// The friction policy of GodObject::move_with_friction(): the state of friction in one tick.
struct CoulombFriction : EuclideanNorm {
  static constexpr bool kHolds = true;

  const FrictionSource* source;
  double coordinates_m;         // size of the coordinates that this tick computes with
  SlideMemory before;           // of the last tick
  bool slides = before.slides;  // the contact slides, from an earlier tick or a step of this tick
  FrictionCone cone = {};  // weighted sum over the planes of the last step, at the end of the step
  std::array<bool, 3> holds_by = {};  // which of these planes have friction
  double rounding_m = 0.0;            // rounding of lag and depth in the last step
  bool is_below_cone = false;         // at the end of the last step, the lag is below the cone
  bool wants_to_slide = false;        // the last step exceeded the cone
  bool slid = false;                  // a step of this tick slid
  bool has_moved = false;             // a step of this tick changed the position
  double shares = 0.0;  // sum of the weights in `cone`; more than 1 if several planes bear the lag
  double mu_of_slide = before.dynamic_friction;  // of the last step that slid
  double left_m = 0.0;  // lag minus the limit of the dynamic cone, at the end of the last step

  // Whether the faces of the last step have friction, and whether a given face has.
  bool holds() const { return cone.holds(); }
  bool may_hold_at(const FaceContact& contact, const Vec3& proxy) const {
    return source->cones.at(contact, proxy).holds();
  }

  // The dynamic coefficient of the faces of the last step; their mean, if they differ.
  double dynamic_coefficient() const {
    return shares > 0.0 ? cone.dynamic_friction / shares : cone.dynamic_friction;
  }

  // moved: the step changed the position. A proxy that exceeded the cone but could not move keeps
  // its state.
  void end_step(bool moved) {
    has_moved = has_moved || moved;
    if (wants_to_slide && moved) {
      slides = slid = true;
      if (shares > 0.0) mu_of_slide = dynamic_coefficient();  // else no face bears the lag
    }
    wants_to_slide = false;
  }

  // Resets the state before the cones of a step are queried.
  void begin_step() {
    cone = {};
    shares = 0.0;
    holds_by = {};
    is_below_cone = false;
    left_m = 0.0;
    wants_to_slide = false;
  }

  // Whether the contact slides at the end of the tick: its lag is on the dynamic cone of the faces
  // that hold the proxy then. A lag below that cone sticks, even if the proxy has slid to its
  // place.
  bool slides_here() const { return slides && !is_below_cone; }

  // Whether the next tick begins as a sliding one. A sphere that slides off one of two faces comes
  // down on the other, which may leave its lag below the cone although nothing but the normal has
  // changed. It slides again when its lag has grown back to the dynamic cone; if the lag does not
  // grow, the hand no longer moves on, and the contact sticks.
  bool slides_on() const {
    const double difference = std::abs(mu_of_slide - dynamic_coefficient());
    const bool is_one_material = difference <= kConeRoundoff * mu_of_slide;
    const bool grows = before.excess_m < 0.0 && left_m > before.excess_m;
    return slides_here() || (slides && is_one_material && (has_moved || grows));
  }
  SlideMemory after() const {
    if (!slides_on()) return {};
    return {true, mu_of_slide, is_below_cone ? left_m : 0.0};
  }

  ProxyState complete(ProxyState state) const {
    // A proxy whose tick was capped between two faces keeps its earlier state.
    if (state.in_contact && state.active_planes == 0 && slides) {
      state.friction = FrictionState::kSlides;
    }
    if (!state.in_contact || state.active_planes == 0 || !cone.holds()) return state;
    state.is_held = true;
    state.slid = slid;
    state.friction = slides_here() ? FrictionState::kSlides : FrictionState::kSticks;
    state.cone = cone;
    return state;
  }

  // By how much a lag exceeds the dynamic cone at a depth.
  double excess_m(double lag_m, double depth_m) const {
    return lag_m - cone.dynamic_friction * depth_m;
  }

  // Decides whether the proxy slides from a place with this lag and depth, and whether the lag is
  // below the cone there.
  void compare(double lag_m, double depth_m) {
    const double mu = slides ? cone.dynamic_friction : cone.static_friction;
    wants_to_slide = lag_m > mu * depth_m + (1.0 + mu) * rounding_m;
    set_below_cone(excess_m(lag_m, depth_m));
  }
  void set_below_cone(double excess_m) {
    left_m = excess_m;
    is_below_cone = excess_m < -(1.0 + cone.dynamic_friction) * rounding_m;
  }

  // The fraction of a step that friction permits, in [0, 1], if the coefficients are the same along
  // the step.
  double part_left(double lag_m, double depth_m) const {
    return wants_to_slide ? std::max(0.0, 1.0 - cone.dynamic_friction * depth_m / lag_m) : 0.0;
  }
};

}  // namespace

// How the active planes bear the lag that the proxy would have without friction.
struct GodObject::Bearing {
  std::array<double, 3> shares{};  // of the planes in the depth
  double lag_m = 0.0;              // tangential lag at the proxy's position
  double depth_m = 0.0;
};

// Computes the cone of the active planes for a proxy at this place.
template <typename Friction>
void GodObject::find_cone_at(const Vec3& place, const Bearing& bearing, Friction& friction) {
  friction.cone = {};
  friction.shares = bearing.shares[0] + bearing.shares[1] + bearing.shares[2];
  tracer_.count(Work::kContact, static_cast<std::size_t>(step_.active_count()));
  for (std::size_t i = 0; i < static_cast<std::size_t>(step_.active_count()); ++i) {
    const FaceContact& contact = step_.active_contact(i);
    const FrictionCone cone = friction.source->cones.at(contact, place);
    friction.holds_by[i] = friction.holds_by[i] || cone.holds();
    friction.cone.static_friction += bearing.shares[i] * cone.static_friction;
    friction.cone.dynamic_friction += bearing.shares[i] * cone.dynamic_friction;
  }
}

// Compares the lag with the cone of the active planes at the proxy's position.
template <typename Friction>
GodObject::Bearing GodObject::find_bearing(Friction& friction) {
  friction.begin_step();
  const Vec3 lag = proxy_ + step_.displacement_m() - goal_;
  Bearing bearing;
  bearing.lag_m = step_.displacement_m().norm();
  bearing.depth_m = lag.norm();
  const auto count = static_cast<std::size_t>(step_.active_count());
  std::array<Vec3, 3> normals;
  double farthest_body_m = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    normals[i] = plane_normal(i);
    const ContactBody& body = world_->body(step_.active_contact(i).face.body);
    farthest_body_m = std::max(farthest_body_m, body.T_solver_body.translation_m.lpNorm<1>());
  }
  friction.rounding_m = kConeRoundoff * (friction.coordinates_m + farthest_body_m);
  bearing.shares = bearing_parts(lag, std::span(normals).first(count));
  for (double& share : bearing.shares) {
    share = bearing.depth_m > 0.0 ? share / bearing.depth_m : 0.0;
  }
  find_cone_at(proxy_, bearing, friction);
  friction.compare(bearing.lag_m, bearing.depth_m);
  return bearing;
}

// Computes the state of friction at the proxy's position.
template <typename Friction>
void GodObject::find_friction_here(Friction& friction) {
  friction.begin_step();
  if (step_.active_count() > 0) find_bearing(friction);
  friction.wants_to_slide = false;
}

// Shortens the step to the part that friction permits. False if the active planes have no friction,
// neither at the proxy's position nor at the end of the step.
template <typename Friction>
bool GodObject::hold_by(Friction& friction) {
  friction.begin_step();
  if (step_.active_count() == 0) return false;
  Bearing bearing = find_bearing(friction);
  const bool holds_here = friction.holds();
  if (holds_here && step_.displacement_m().isZero(0.0)) {
    // A slide may be so short that its gain is lost in the rounding of squared distances. A face
    // whose dynamic coefficient is 0 bears no lag along it, however short.
    constexpr auto kPrecise = Feasibility::kAtStartPrecise;
    const Vec3 lag = goal_ - proxy_;
    const PlaneProjection precise =
        motion_plane_ ? project_within(*motion_plane_, step_.planes(), lag, kPrecise)
                      : project_onto_planes(step_.planes(), lag, kPrecise);
    if (precise.solved && precise.active_count > 0) {
      step_.solve(precise);
      bearing = find_bearing(friction);
    }
  }
  Vec3& step = step_.displacement_m();
  if (!friction.wants_to_slide) {
    if (holds_here) step.setZero();
    return holds_here;
  }
  // The law holds at the end of the slide, where the coefficients may differ.
  const auto excess_m = [&](double part) {
    find_cone_at(proxy_ + part * step, bearing, friction);
    return friction.excess_m((1.0 - part) * bearing.lag_m, bearing.depth_m);
  };
  double part = friction.part_left(bearing.lag_m, bearing.depth_m);
  const double mu = friction.cone.dynamic_friction;
  double left_m = excess_m(part);
  if (friction.cone.dynamic_friction != mu) {
    part = part_to_cone(excess_m, 0.25 * friction.rounding_m);
    left_m = excess_m(part);
  }
  friction.set_below_cone(left_m);
  if (!holds_here && !friction.holds()) return false;
  step *= part;
  return true;
}

// Moves a sphere that only an edge or vertex holds round the feature, until its lag has fallen to
// the cone there. A slide along the tangent plane would need many steps: see roll_to_answer().
template <typename Friction>
bool GodObject::roll_to_cone(Friction& friction) {
  if (step_.active_count() != 1) return false;
  const FaceContact& held = step_.active_contact(0);
  FaceContact contact = tracer_.contact_at(held.face, proxy_, held.normal);
  if (contact.feature == TriangleFeature::kFace) return false;
  const std::optional<RollArc> arc = arc_round(contact);
  if (!arc) return false;
  const auto excess_m = [&](double part) {
    tracer_.count(Work::kContact, 1);
    const Vec3 place = arc->place(part);
    contact.feature_point = arc->foot(place);
    contact.normal = (place - contact.feature_point).normalized();
    friction.cone = friction.source->cones.at(contact, place);
    friction.shares = 1.0;
    const Vec3 lag = place - goal_;
    const Vec3 normal = in_motion_plane(contact.normal).value_or(contact.normal);
    const double depth_m = lag.dot(normal);
    const double lag_m = (lag - depth_m * normal).norm();
    // Beyond the place that is nearest to the goal, the lag counts as negative.
    return friction.excess_m(std::copysign(lag_m, -arc->heading(part).dot(lag)), depth_m);
  };
  if (excess_m(0.0) <= 0.0 || excess_m(1.0) > friction.rounding_m) return false;
  const double part = part_to_cone(excess_m, 0.25 * friction.rounding_m);
  (void)excess_m(part);  // the contact and the cone at the end of the roll
  if (!rolls_along(*arc, part)) return false;
  contact.clearance_m = scale().stop_m;
  step_.clear_planes();
  add_plane(contact);
  step_.solve_by_first();
  return true;
}

// Whether friction holds the proxy at its position after the last tick. If so, no search is needed,
// and the position stays the same bit for bit.
template <typename Friction>
bool GodObject::stays_at_rest(Friction& friction) {
  const bool is_held = rest_.is_settled() && rest_.has_friction();
  if (!is_held || step_.planes().size() < rest_.holding().size()) return false;
  step_.solve(project(friction, step_.planes()));
  if (!step_.is_solved() || !hold_by(friction)) return false;
  if (!step_.displacement_m().isZero(0.0)) return false;
  if (leaves_edges(Progress::kHeld, friction) != Escape::kNone) return false;
  if (tracer_.is_cut_short()) return false;  // not all attempts have been made
  rest_.settle(goal_waits_);
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
  CoulombFriction friction{{}, &source, coordinates_m, rest_.slide()};
  const ProxyState state = move(goal, motion_plane_normal, friction);
  rest_.end_with_friction(state.is_held ? friction.holds_by : std::array<bool, 3>{},
                          state.in_contact ? friction.after() : SlideMemory{});
  return state;
}

}  // namespace palpate
