#pragma once

// The solver steps of one tick of the god-object, as templates over the friction policy. Two source
// files instantiate them, one with and one without friction, so that a world without friction runs
// no friction code. Private to the files god_object*.cpp.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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

// What move() knows of its tick.
struct GodObject::Tick {
  WorkUnits work_of_bodies = 0;  // of move_bodies() in this tick
  // The tick begins with the planes of the last one, which was cut short.
  bool keeps_planes = false;
  // It also repeats the interrupted step from identical input: it makes the same queries, and the
  // trace log answers them.
  bool repeats = false;
  int steps = 0;
  int looks = 0;             // how often a settled sphere has computed its contact normals again
  Vec3 from = Vec3::Zero();  // position at the start of the present step
};

template <typename Friction>
ProxyState GodObject::move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                           Friction& friction) {
  Tick tick = begin_move(goal, motion_plane_normal);
  if (rest_.known().empty() && tracer_.is_free(proxy_, goal)) return move_freely();
  if (!tick.keeps_planes) seed_from_last_tick();
  if (tracer_.is_cut_short()) return stay(friction);
  if (!tick.repeats) is_slow_ = rest_.goes_on();
  if (tick.repeats) tracer_.repeat_step();
  if constexpr (Friction::kHolds) {
    limit_detours();
    if (stays_at_rest(friction)) return friction.complete(report(1, false));
  }
  if (tick.keeps_planes && !tick.repeats) finish_last_step(friction);
  Verdict verdict = Verdict::kGoesOn;
  while (tick.steps < settings_.accuracy.iterations) {
    begin_step(tick);
    const Progress progress = take_step(friction);
    if constexpr (Friction::kHolds) friction.end_step(proxy_ != tick.from);
    if (progress == Progress::kStopped) continue;
    verdict = judge(progress, tick, friction);
    if (verdict == Verdict::kRests || verdict == Verdict::kEnds) break;
    if (verdict == Verdict::kGoesOn) renew_planes(progress, tick, friction);
  }
  const bool capped = verdict != Verdict::kRests;
  end_move(tick, capped, friction);
  if constexpr (Friction::kHolds) return friction.complete(report(tick.steps, capped));
  return report(tick.steps, capped);
}

// Begins the move of a tick towards this goal.
inline GodObject::Tick GodObject::begin_move(const Vec3& goal,
                                             const std::optional<Vec3>& motion_plane_normal) {
  Tick tick;
  tick.work_of_bodies = begin_tick();
  tick.keeps_planes = rest_.is_cut_short() && is_motion_plane(motion_plane_normal);
  tick.repeats = tick.keeps_planes && interrupted_.is_repeated_by(goal, proxy_);
  if (!tick.repeats) goal_waits_ = rest_.goes_on() && goal == goal_;
  goal_ = goal;
  set_motion_plane(motion_plane_normal);
  path_.clear();
  path_.push_back(proxy_);
  return tick;
}

inline void GodObject::begin_step(Tick& tick) {
  ++tick.steps;
  if (tick.steps > kPatience) become_slow();
  limit_detours();
  if (!tick.repeats || tick.steps > 1) tracer_.begin_step();
  tick.from = proxy_;
}

// Judges a step that no new face stopped. A point is at rest if one plane stopped it and the face
// of that plane is under it. A proxy is also at rest if the planes that hold it were computed at
// its present position (update_planes) and no attempt improves the position.
template <typename Friction>
inline GodObject::Verdict GodObject::judge(Progress progress, Tick& tick, Friction& friction) {
  if (tracer_.is_cut_short()) return Verdict::kEnds;
  const bool is_stuck = progress == Progress::kStuck;
  const bool is_settled = !is_stuck && settled();
  if constexpr (Friction::kHolds) {
    // The cone of a sphere is that of the normals at its place.
    const bool is_turned = tracer_.radius_m() > 0.0 && !step_.is_current();
    if (is_settled && is_turned && friction.holds() && tick.looks < kMostLooks) {
      ++tick.looks;
      update_planes();
      return Verdict::kTriesAgain;
    }
  }
  if (is_settled) return Verdict::kRests;
  if (!step_.is_current()) return Verdict::kGoesOn;
  if (progress == Progress::kMoved) return Verdict::kGoesOn;
  const Escape escape = leaves_edges(progress, friction);
  if (escape == Escape::kLeft) return Verdict::kTriesAgain;
  if (is_stuck || tracer_.is_cut_short()) return Verdict::kEnds;
  return escape == Escape::kRoundingDecides ? Verdict::kEnds : Verdict::kRests;
}

// Prepares the next step: computes the planes at the present position, and extends the slide of a
// slow sphere.
template <typename Friction>
inline void GodObject::renew_planes(Progress progress, Tick& tick, Friction& friction) {
  const bool may_overreach = !Friction::kHolds && is_slow_ && tracer_.radius_m() > 0.0;
  if (may_overreach && progress == Progress::kMoved && roll_between_last_two()) return;
  update_planes();
  if (progress == Progress::kMoved && step_.planes().empty()) go_on_over_next_face(friction);
  if constexpr (!Friction::kHolds) {
    if (!may_overreach) return;
    tick.steps += overreach(progress, settings_.accuracy.iterations - tick.steps, friction);
    tick.steps += leap(settings_.accuracy.iterations - tick.steps, friction);
  }
}

// Ends the move: stores for the next tick where the proxy rests or what is to be completed.
template <typename Friction>
inline void GodObject::end_move(const Tick& tick, bool capped, Friction& friction) {
  const bool is_cut_short = tracer_.is_cut_short();
  if (is_cut_short) keep_step_for_next_tick(tick.from, tick.work_of_bodies);
  if (capped) find_holding_planes(friction);
  keep_contacts_for_next_tick(capped);
  tracer_.look_ahead(proxy_, proxy_ - path_.front(), tick.steps == 1);
  if (capped) {
    rest_.cap(is_cut_short);
  } else {
    rest_.settle(goal_waits_);
  }
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

// Takes one step towards the point nearest to the goal that the planes allow.
template <typename Friction>
GodObject::Progress GodObject::take_step(Friction& friction) {
  tracer_.count(Work::kStep, 1);
  tracer_.count(Work::kPlane, step_.planes().size());
  if (step_.planes().empty() && !enter_bounds()) return Progress::kMoved;
  step_.solve(project(friction, step_.planes()));
  if (!step_.is_solved()) return Progress::kStuck;
  const Way way = find_way(friction);
  if (way == Way::kRolled) return Progress::kStopped;
  // A free proxy moves to exactly the goal, however near the goal is.
  const bool is_free = step_.active_count() == 0;
  Vec3& step = step_.displacement_m();
  if (motion_plane_ && !is_free) step = onto_motion_plane(step);
  if (!is_free && is_held_at_once(friction, step)) return Progress::kHeld;
  Vec3 target = is_free ? goal_ : Vec3(proxy_ + step);
  const bool leaves = !bounds_.contains(target);
  if (leaves) target = leave_bounds(target);
  if (const auto stopped = stop_at_first_hit(target)) return *stopped;
  if (leaves && is_free) commit(goal_);
  return way == Way::kFlies ? Progress::kStopped : Progress::kMoved;
}

// Decides how a step begins that the planes allow: shortens it by friction, or moves a sphere round
// the feature that holds it. Friction acts only at touched planes. The plane of the next face is an
// exception, unless that face turns out to have friction where the slide would end.
template <typename Friction>
inline GodObject::Way GodObject::find_way(Friction& friction) {
  const bool is_sphere = tracer_.radius_m() > 0.0;
  if constexpr (Friction::kHolds) {
    const bool is_off = is_off_planes();
    const bool is_far = is_off && !step_.is_over_next_face();
    const bool holds = !is_far && hold_by(friction);
    if (is_far || (is_off && holds)) {
      friction.begin_step();
      step_.displacement_m() = step_to_planes();
      return Way::kFlies;
    }
    if (is_sphere && holds) {
      return friction.wants_to_slide && roll_to_cone(friction) ? Way::kRolled : Way::kSlides;
    }
  }
  return is_sphere && roll_to_answer() ? Way::kRolled : Way::kSlides;
}

// Whether a proxy that planes hold need not take this step. It has converged when its step is
// shorter than the tolerance. A slow proxy may also rest after a small step, but only if it touches
// the planes: farther away, it could miss an edge directly in front of it. Under friction it slides
// on, until its lag is on the cone.
template <typename Friction>
inline bool GodObject::is_held_at_once(const Friction& friction, const Vec3& step) const {
  if (has_converged(step)) return true;
  bool may_rest = is_slow_ && step_.is_current();
  if constexpr (Friction::kHolds) {
    may_rest = may_rest && !(friction.holds() && friction.wants_to_slide);
  }
  return may_rest && is_little(friction, step) && step_.touches_faces(scale().stand_off_m);
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
