#pragma once

// The solver steps of one tick of the god-object, as templates over the friction policy. Two source
// files instantiate them, one with and one without friction, so that a world without friction runs
// no friction code. Private to the files god_object*.cpp.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "haptics/proxy/god_object.h"

namespace palpate {

// The part of a policy that states the norm of distances to the goal: the Euclidean one.
struct EuclideanNorm {
  static double length(const Vec3& v) { return v.norm(); }
  static PlaneProjection project(std::span<const ContactPlane> planes, const Vec3& target) {
    return project_onto_planes(planes, target);
  }
  static PlaneProjection project_within(const MotionPlane& motion_plane,
                                        std::span<const ContactPlane> planes, const Vec3& target) {
    return palpate::project_within(motion_plane, planes, target);
  }
  // The point nearest to v on the line through 0 in a unit direction, and on the plane through 0
  // with a unit normal.
  static Vec3 along(const Vec3& v, const Vec3& line) { return v.dot(line) * line; }
  static Vec3 within(const Vec3& v, const Vec3& normal) { return v - v.dot(normal) * normal; }
};

// The friction policy of GodObject::move_to(): no face has friction.
struct NoFriction : EuclideanNorm {
  static constexpr bool kHolds = false;
  static bool holds() { return false; }
  static bool may_hold_at(const FaceContact&, const Vec3&) { return false; }
};

// The state of the solver at one position of the proxy, to which the solver can return.
struct GodObject::ProxyPlace {
  Vec3 proxy;
  std::size_t corners;  // number of corners of the path
  ProxyStep step;
};

// The largest number of corners of the path along tangents on which a sphere moves round an edge or
// vertex. Its largest turn, a right angle, needs this number.
constexpr std::size_t kMostRollCorners = 7;

// A sphere moves round a feature along tangents. Each turns by at most this angle, so that the
// corners are 0.8 % of the radius off the arc.
constexpr double kRollTurn_rad = 0.25;

// A path of a sphere's centre round an edge or vertex, with the part of the path as parameter. It
// is a circle, a helix, or an ellipse in the plane of motion. Solver frame, m.
struct RollArc {
  Vec3 centre = Vec3::Zero();
  Vec3 u = Vec3::Zero();              // from the centre to the start
  Vec3 v = Vec3::Zero();              // from the centre to the place a right angle on
  Vec3 drift = Vec3::Zero();          // along the edge, over the whole path
  double angle_rad = 0.0;             // of the whole path
  Vec3 feature_point = Vec3::Zero();  // on the edge or vertex
  Vec3 edge = Vec3::Zero();           // direction of the edge; zero for a vertex

  // stretch: distance from the centre relative to the arc, for corners of tangents.
  Vec3 place(double part, double stretch = 1.0) const {
    const double turn_rad = part * angle_rad;
    return centre + part * drift + stretch * (std::cos(turn_rad) * u + std::sin(turn_rad) * v);
  }
  // The direction of motion, not normalised.
  Vec3 heading(double part) const {
    const double turn_rad = part * angle_rad;
    return drift + angle_rad * (std::cos(turn_rad) * v - std::sin(turn_rad) * u);
  }
  // The point of the feature that is nearest to a place.
  Vec3 foot(const Vec3& place) const {
    return feature_point + (place - feature_point).dot(edge) * edge;
  }
};

// Unit normals cancel if their sum is not longer than this length, which rounding alone can give.
constexpr double kCancelledNormal = 16 * std::numeric_limits<double>::epsilon();

// Number of steps after which a tick counts as slow; overreaching and leaps then begin.
constexpr int kPatience = 8;

// Number of steps within which a proxy that was moved beyond the end of a slide must come nearer to
// the goal than it was at the end of the slide.
constexpr int kStepsToFall = 5;

// Number of times that a settled sphere computes its contact normals again under friction.
constexpr int kMostLooks = 3;

// Largest increase of the distance to the goal on a sphere's path, relative to the radius.
constexpr double kDetourPerRadius = 0.008;

// Whether `to` is nearer to the goal than `from` by more than little_m().
template <typename Friction>
bool GodObject::is_gain(const Friction& friction, const Vec3& from, const Vec3& to) const {
  return friction.length(from - goal_) - friction.length(to - goal_) > little_m();
}

// Sets the largest distance to the goal that is allowed on a sphere's path from its present
// position.
inline void GodObject::limit_detours() {
  const double radius_m = tracer_.radius_m();
  if (radius_m > 0.0) most_lag_m_ = (proxy_ - goal_).norm() + kDetourPerRadius * radius_m;
}

template <typename Friction>
ProxyState GodObject::move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                           Friction& friction) {
  const WorkUnits work_of_bodies = begin_tick();
  const bool keeps_planes = rest_.is_cut_short() && is_motion_plane(motion_plane_normal);
  // If the interrupted step is repeated from identical input, it makes the same queries, and the
  // trace log answers them.
  const bool repeats = keeps_planes && interrupted_.is_repeated_by(goal, proxy_);
  if (!repeats) goal_waits_ = rest_.goes_on() && goal == goal_;
  goal_ = goal;
  set_motion_plane(motion_plane_normal);
  path_.clear();
  path_.push_back(proxy_);
  if (rest_.known().empty() && tracer_.is_free(proxy_, goal)) return move_freely();
  if (!keeps_planes) seed_from_last_tick();
  if (tracer_.is_cut_short()) return stay(friction);
  if (!repeats) is_slow_ = rest_.goes_on();
  if (repeats) tracer_.repeat_step();
  if constexpr (Friction::kHolds) {
    limit_detours();
    if (stays_at_rest(friction)) return friction.complete(report(1, false));
  }
  if (keeps_planes && !repeats) finish_last_step(friction);
  bool capped = true;
  int iteration = 0;
  Vec3 from = proxy_;  // position at the start of the present step
  [[maybe_unused]] int looks_again = 0;
  while (iteration < settings_.accuracy.iterations) {
    ++iteration;
    if (iteration > kPatience) become_slow();
    limit_detours();
    if (!repeats || iteration > 1) tracer_.begin_step();
    from = proxy_;
    const Progress progress = take_step(friction);
    if constexpr (Friction::kHolds) friction.end_step(proxy_ != from);
    if (progress == Progress::kStopped) continue;
    if (tracer_.is_cut_short()) break;
    // A point is at rest if one plane stopped it and the face of that plane is under it. A proxy is
    // also at rest if the planes that hold it were computed at its present position
    // (update_planes).
    bool is_settled = progress != Progress::kStuck && settled();
    if constexpr (Friction::kHolds) {
      // The cone of a sphere is that of the normals at its place.
      const bool is_turned = tracer_.radius_m() > 0.0 && !step_.is_current();
      if (is_settled && is_turned && friction.holds() && looks_again < kMostLooks) {
        ++looks_again;
        update_planes();
        continue;
      }
    }
    bool rounding_decides = false;
    if (!is_settled && progress != Progress::kMoved && step_.is_current()) {
      const Escape escape = leaves_edges(progress, friction);
      if (escape == Escape::kLeft) continue;
      if (tracer_.is_cut_short()) break;
      rounding_decides = escape == Escape::kRoundingDecides;
      is_settled = progress == Progress::kHeld && !rounding_decides;
    }
    capped = !is_settled;
    const bool is_stuck = progress == Progress::kStuck || rounding_decides;
    if (is_settled || (is_stuck && step_.is_current())) break;
    const bool may_overreach = !Friction::kHolds && is_slow_ && tracer_.radius_m() > 0.0;
    if (may_overreach && progress == Progress::kMoved && roll_between_last_two()) continue;
    update_planes();
    if (progress == Progress::kMoved && step_.planes().empty()) go_on_over_next_face(friction);
    if constexpr (!Friction::kHolds) {
      if (may_overreach) {
        iteration += overreach(progress, settings_.accuracy.iterations - iteration, friction);
        iteration += leap(settings_.accuracy.iterations - iteration, friction);
      }
    }
  }
  const bool cut_short = tracer_.is_cut_short();
  if (cut_short) keep_step_for_next_tick(from, work_of_bodies);
  if (capped) find_holding_planes(friction);
  keep_contacts_for_next_tick(capped);
  tracer_.look_ahead(proxy_, proxy_ - path_.front(), iteration == 1);
  if (capped) {
    rest_.cap(cut_short);
  } else {
    rest_.settle(goal_waits_);
  }
  if constexpr (Friction::kHolds) return friction.complete(report(iteration, capped));
  return report(iteration, capped);
}

// Ends a tick in which the bodies have used the whole budget. The proxy keeps its position.
template <typename Friction>
[[gnu::cold]] ProxyState GodObject::stay(Friction& friction) {
  step_.clear_solution();
  find_holding_planes(friction);
  keep_contacts_for_next_tick(true);
  if constexpr (Friction::kHolds) return friction.complete(report(0, true));
  return report(0, true);
}

// Completes the step in which the last tick was cut short, for the goal of that step. Does nothing
// if the goal has since moved by more than half of its former distance from the proxy. If the
// completed step increases the distance to the present goal, it is undone.
template <typename Friction>
[[gnu::cold]] void GodObject::finish_last_step(Friction& friction) {
  if (!interrupted_.is_trace(tracer_.unfinished(), proxy_)) return;
  if (!interrupted_.is_still_wanted(goal_, proxy_)) return;
  limit_detours();
  const ProxyPlace before = place_now();
  const Vec3 target = interrupted_.target();
  stop_at_first_hit(target);
  if (tracer_.is_cut_short()) return;
  if (friction.length(proxy_ - goal_) > friction.length(before.proxy - goal_)) return_to(before);
  [[maybe_unused]] const bool moved = proxy_ != before.proxy;
  if constexpr (Friction::kHolds) {
    friction.begin_step();
    friction.wants_to_slide = moved;
    friction.end_step(moved);
  }
}

// Determines the planes that hold the proxy after a capped tick. The plane of the face that the
// proxy met last may be one of them.
template <typename Friction>
[[gnu::cold]] void GodObject::find_holding_planes(Friction& friction) {
  if constexpr (Friction::kHolds) {
    // The state is that of the faces that the proxy touches now, not that of the last step.
    step_.solve(project(friction, step_.planes()));
    if (!step_.is_solved() || is_off_planes()) step_.clear_solution();
    find_friction_here(friction);
  } else {
    if (step_.active_count() > 0) return;
    step_.solve(project(friction, step_.planes()));
    if (!step_.is_solved()) step_.clear_solution();
  }
}

// The displacement to the point nearest to the goal that these planes allow, within the plane of
// motion if there is one.
template <typename Friction>
PlaneProjection GodObject::project(const Friction& friction,
                                   std::span<const ContactPlane> planes) const {
  const Vec3 lag = goal_ - proxy_;
  return motion_plane_ ? friction.project_within(*motion_plane_, planes, lag)
                       : friction.project(planes, lag);
}

template <typename Friction>
GodObject::Progress GodObject::take_step(Friction& friction) {
  tracer_.count(Work::kStep, 1);
  tracer_.count(Work::kPlane, step_.planes().size());
  if (step_.planes().empty() && !enter_bounds()) return Progress::kMoved;
  step_.solve(project(friction, step_.planes()));
  if (!step_.is_solved()) return Progress::kStuck;
  const bool is_sphere = tracer_.radius_m() > 0.0;
  bool flies = false;  // to the first plane, without a slide
  if constexpr (Friction::kHolds) {
    // Friction acts only at touched planes. The plane of the next face is an exception, unless that
    // face turns out to have friction where the slide would end.
    const bool is_off = is_off_planes();
    flies = is_off && !step_.is_over_next_face();
    const bool holds = !flies && hold_by(friction);
    flies = flies || (is_off && holds);
    if (flies) {
      friction.begin_step();
      step_.displacement_m() = step_to_planes();
    } else if (is_sphere && holds) {
      if (friction.wants_to_slide && roll_to_cone(friction)) return Progress::kStopped;
    } else if (is_sphere && roll_to_answer()) {
      return Progress::kStopped;
    }
  } else {
    if (is_sphere && roll_to_answer()) return Progress::kStopped;
  }
  // A free proxy moves to exactly the goal, however near the goal is. A proxy that planes hold has
  // converged when its step is shorter than the tolerance.
  const bool is_free = step_.active_count() == 0;
  Vec3& step = step_.displacement_m();
  if (motion_plane_ && !is_free) step = onto_motion_plane(step);
  if (!is_free && has_converged(step)) return Progress::kHeld;
  // A slow proxy may also rest after a small step, but only if it touches the planes: farther away,
  // it could miss an edge directly in front of it.
  // Under friction it slides on, until its lag is on the cone.
  bool may_rest = is_slow_ && step_.is_current() && !is_free;
  if constexpr (Friction::kHolds) {
    may_rest = may_rest && !(friction.holds() && friction.wants_to_slide);
  }
  if (may_rest && is_little(friction, step) && step_.touches_faces(scale().stand_off_m))
    return Progress::kHeld;
  Vec3 target = is_free ? goal_ : Vec3(proxy_ + step);
  const bool leaves = !bounds_.contains(target);
  if (leaves) target = leave_bounds(target);
  if (const auto stopped = stop_at_first_hit(target)) return *stopped;
  if (leaves && is_free) commit(goal_);
  return flies ? Progress::kStopped : Progress::kMoved;
}

// A point that has slid off the face that held it is usually over the next face. This function adds
// the plane of the next face before the point touches it. The function does nothing if the next
// face may have friction, because friction must not act before contact.
template <typename Friction>
void GodObject::go_on_over_next_face(const Friction& friction) {
  if (tracer_.radius_m() > 0.0 || motion_plane_ || friction.holds()) return;
  if (step_.active_count() != 1) return;
  const FaceRef& left = step_.active_contact(0).face;
  const auto next = tracer_.contact_over_next(left, proxy_, goal_);
  if (!next || next->clearance_m <= near_m() || friction.may_hold_at(*next, proxy_)) return;
  add_plane(*next);
  step_.set_over_next_face();
}

// Extends a slide by the sum of the slides that will follow. If the penetration depth is about as
// large as the radius of curvature of the surface, each slide along a tangent plane covers only a
// small part of the remaining path: a slide y is followed by slides k y, k^2 y, ... Returns the
// number of steps taken.
template <typename Friction>
[[gnu::cold]] int GodObject::overreach(Progress progress, int most_steps, Friction& friction) {
  const Vec3 slide = progress == Progress::kMoved && step_.active_count() > 0
                         ? step_.displacement_m()
                         : Vec3(Vec3::Zero());
  if (slide.isZero(0.0)) return 0;
  // At a maximum of the lag, the least reach makes the gain larger than the amount by which the
  // distance to a face may differ before and after.
  const double least_m2 = scale().stand_off_m * (proxy_ - goal_).norm();
  const double reach = extrapolation_.reach_of(slide, proxy_, least_m2);
  if (reach <= 1.0) return 0;
  const Attempt attempt = fall_from_beyond((reach - 1.0) * slide, most_steps, friction);
  if (!attempt.is_nearer) extrapolation_.fail(attempt.beyond_m, slide.norm());
  return attempt.steps;
}

// Every few steps, extends the path of these steps by a straight segment in its mean direction. A
// single slide predicts that direction poorly if the proxy moves to and fro between features.
// Returns the number of steps taken.
template <typename Friction>
[[gnu::cold]] int GodObject::leap(int most_steps, Friction& friction) {
  if (!extrapolation_.is_leap_due()) return 0;
  const Vec3 displacement = extrapolation_.leap_from(proxy_);
  const Attempt attempt = fall_from_beyond(displacement, most_steps, friction);
  if (attempt.steps > 0) extrapolation_.end_leap(proxy_, attempt.is_nearer);
  return attempt.steps;
}

// Moves the proxy along `displacement`, even away from the goal, as far as the limit of detours
// (most_lag_m_) permits, and then lets it fall back to the surface by ordinary steps. Undoes the
// attempt unless the proxy ends nearer to the goal. The result has 0 steps if too few steps are
// left or if the displacement is zero, out of the plane of motion or out of bounds.
template <typename Friction>
GodObject::Attempt GodObject::fall_from_beyond(const Vec3& displacement, int most_steps,
                                               Friction& friction) {
  const double length_m = displacement.norm();
  if (length_m == 0.0 || most_steps < kStepsToFall) return {};
  const std::optional<Vec3> along = in_motion_plane(displacement / length_m);
  if (!along) return {};
  limit_detours();
  const Vec3 lag = proxy_ - goal_;
  const double lag_m = lag.norm();
  const double leads_m = -lag.dot(*along);
  const double farthest_m =
      leads_m + std::sqrt(leads_m * leads_m + (most_lag_m_ + lag_m) * (most_lag_m_ - lag_m));
  const double beyond_m = std::min(length_m, farthest_m);
  const Vec3 target = point_in_motion_plane(proxy_ + beyond_m * *along);
  if (!bounds_.contains(target)) return {};
  const ProxyPlace before = place_now();
  stop_at_first_hit(target);
  step_.clear_planes();
  step_.set_current();
  int steps = 1;
  for (; steps < kStepsToFall; ++steps) {
    const Progress fall = take_step(friction);
    if ((proxy_ - goal_).norm() < lag_m) return {steps, beyond_m, true};
    if (fall != Progress::kStopped) update_planes();
  }
  return_to(before);
  return {steps, beyond_m, false};
}

}  // namespace palpate
