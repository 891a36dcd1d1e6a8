#pragma once

// How the god-object moves in one tick, for the files that do it with and without friction. Each
// compiles its own copy: a world without friction runs no line of the other.

#include <algorithm>
#include <cmath>

#include "haptics/god_object.h"

namespace palpate {

struct NoFriction {
  static constexpr bool kHolds = false;
};

// Where the proxy was, to come back to.
struct GodObject::ProxyPlace {
  Vec3 proxy;
  std::size_t corners;
  std::array<ContactPlane, kMaxContactPlanes> planes;
  std::array<FaceContact, kMaxContactPlanes> contacts;
  int plane_count;
  PlaneProjection projection;
  bool planes_are_current;
};

// Steps after which a tick is slow, and is helped on.
constexpr int kPatience = 8;

// To a slow proxy a step of so many stand-offs, a tenth of what a way has to gain, is none.
constexpr double kLittlePerStandOff = 10.0;

// Steps in which a proxy that has gone too far must have come nearer.
constexpr int kStepsToFall = 5;

// Faces tried at a vertex. Among more of them a free way is hardly wider than a stand-off.
constexpr std::size_t kMostAtVertex = 12;

// How far from a vertex they are looked for: three planes hold a point within a few stand-offs of
// it.
constexpr double kAroundPerStandOff = 4.0;

// How much farther from the goal it may get on the way, of the radius.
constexpr double kDetourPerRadius = 0.008;

template <typename Friction>
ProxyState GodObject::move(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                           Friction& friction) {
  goal_ = goal;
  motion_plane_normal_ = motion_plane_normal;
  path_.clear();
  path_.push_back(proxy_);
  if (last_count_ == 0 && tracer_.is_free(proxy_, goal)) return move_freely();
  seed_from_last_tick();
  if constexpr (Friction::kHolds) {
    if (stays_at_rest(friction)) return friction.complete(report(1, false));
  }
  bool capped = true;
  settled_ = false;
  is_slow_ = false;
  last_slide_m_.setZero();
  int iteration = 0;
  while (iteration < settings_.accuracy.iterations) {
    ++iteration;
    is_slow_ = iteration > kPatience;
    [[maybe_unused]] Vec3 before;
    if constexpr (Friction::kHolds) before = proxy_;
    const Progress progress = take_step(friction);
    if constexpr (Friction::kHolds) friction.end_step(proxy_ != before);
    if (progress == Progress::kStopped) continue;
    // A point that went to where one plane lets it go, and has its face under it, is at rest. So is
    // a proxy that planes hold which are all those of what it touches here (update_planes).
    settled_ = progress != Progress::kStuck && settled();
    if (!settled_ && progress == Progress::kHeld && planes_are_current_) {
      settled_ = !leaves_edges(friction);
      if (!settled_) continue;
    }
    capped = !settled_;
    if (settled_ || (progress == Progress::kStuck && planes_are_current_)) break;
    update_planes();
    if constexpr (!Friction::kHolds) {
      if (is_slow_ && tracer_.radius_m() > 0.0)
        iteration += overreach(progress, settings_.accuracy.iterations - iteration, friction);
    }
  }
  if (capped) name_what_holds(friction);
  keep_contacts_for_next_tick(capped);
  tracer_.look_ahead(proxy_, proxy_ - path_.front(), iteration == 1);
  confirmed_ = !capped;
  if constexpr (Friction::kHolds) return friction.complete(report(iteration, capped));
  return report(iteration, capped);
}

// A tick that was cut short when the proxy had just met a face tells that face, too.
template <typename Friction>
void GodObject::name_what_holds(Friction& friction) {
  if (projection_.active_count > 0) return;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved) projection_ = {};
  if constexpr (Friction::kHolds) {
    hold_by(friction);
    friction.wants_to_slide = false;
  }
}

template <typename Friction>
GodObject::Progress GodObject::take_step(Friction& friction) {
  if (plane_count_ == 0 && !enter_bounds()) return Progress::kMoved;
  projection_ = project_onto_planes(planes(), goal_ - proxy_);
  if (!projection_.solved) return Progress::kStuck;
  bool flies = false;
  if constexpr (Friction::kHolds) {
    flies = is_off_planes();
    if (flies) {
      friction.begin_step();
      projection_.displacement_m = way_to_planes();
    } else if (!hold_by(friction) && roll_to_answer()) {
      return Progress::kStopped;
    }
  } else {
    if (roll_to_answer()) return Progress::kStopped;
  }
  // Free, the proxy goes to the goal, to the bit and however near it is; held by planes, it has
  // converged when it hardly moves.
  const bool is_free = projection_.active_count == 0;
  const Vec3& step = projection_.displacement_m;
  if (!is_free && is_none(step)) return Progress::kHeld;
  if (is_slow_ && planes_are_current_ && step.norm() <= kLittlePerStandOff * scale().stand_off_m) {
    return Progress::kHeld;
  }
  Vec3 target = is_free ? goal_ : Vec3(proxy_ + step);
  const bool leaves = !bounds_.contains(target);
  if (leaves) target = proxy_ + leave_bounds(step) * step;  // nothing to touch beyond
  if (const auto stopped = stop_at_first_hit(target)) return *stopped;
  if (leaves && is_free) commit(goal_);
  return flies ? Progress::kStopped : Progress::kMoved;
}

// Where the surface curves about as sharply as the goal is deep, a slide along its tangent plane
// leads only a small part of the way, and so does each one after it: of a slide y, the next ones
// are k y, k^2 y, ... Goes on as far as they will lead together, y / (1 - k), though that leads
// away from the goal at first, and lets the proxy fall back on the surface. Takes all of it back
// unless it comes nearer. Returns how many steps that took.
template <typename Friction>
int GodObject::overreach(Progress progress, int most_steps, Friction& friction) {
  const Vec3 slide = progress == Progress::kMoved && projection_.active_count > 0
                         ? projection_.displacement_m
                         : Vec3(Vec3::Zero());
  if (slide.isZero(0.0)) return 0;
  const double reach = reach_of(slide);
  last_slide_m_ = slide;
  if (reach <= 1.0 || most_steps < kStepsToFall) return 0;
  const ProxyPlace before = place_now();
  const double lag_m = (proxy_ - goal_).norm();
  int steps = 1;
  // At a foot, a distance x along the slide leads x^2 / (2 lag) away, to the first order.
  const double farthest_m = std::sqrt(2.0 * kDetourPerRadius * tracer_.radius_m() * lag_m);
  const double beyond_m = std::min((reach - 1.0) * slide.norm(), farthest_m);
  const Vec3 target = proxy_ + beyond_m * slide.normalized();
  if (!bounds_.contains(target)) return 0;
  stop_at_first_hit(target);
  plane_count_ = 0;
  planes_are_current_ = true;
  for (; steps < kStepsToFall; ++steps) {
    const Progress fall = take_step(friction);
    const double lag_now_m = (proxy_ - goal_).norm();
    if (lag_now_m < lag_m) return steps;
    if (fall != Progress::kStopped) update_planes();
  }
  return_to(before);
  overreach_ = 1.0;
  return steps;
}

// A point beside a triangle is held by its plane, or by its edge or vertex, also where another
// triangle goes on beyond and is what the point is over. Before it is said to rest there, each such
// contact is taken for what is nearest of the triangle, and then left out, all and each alone. At a
// vertex the room is not convex, and a pair of other faces can leave a way on between them: slides
// along each face around and each two are tried. True if any of that led on.
template <typename Friction>
bool GodObject::leaves_edges(Friction& friction) {
  if constexpr (Friction::kHolds) {
    if (slides_up_to_what_holds(friction)) return true;
  }
  if (tracer_.radius_m() > 0.0) return false;
  const PlaneProjection held = projection_;
  std::array<FaceContact, 3> holding;
  const auto count = static_cast<std::size_t>(held.active_count);
  std::size_t beside = 0;
  for (std::size_t i = 0; i < count; ++i) {
    holding[i] = contacts_[held.active[i]];
    beside += holding[i].feature != TriangleFeature::kFace;
  }
  const bool is_vertex = count > 1 && is_at_vertex(std::span(holding).first(count));
  if (beside == 0 && !is_vertex && !(Friction::kHolds && count > 1)) return false;
  std::array<FaceContact, 3> nearest = holding;
  for (std::size_t i = 0; i < count; ++i) {
    if (holding[i].feature != TriangleFeature::kFace) {
      nearest[i] = tracer_.nearest_contact(holding[i].face, proxy_);
    }
  }
  if (beside > 0 && slides_along(std::span(nearest).first(count), friction)) return true;
  for (std::size_t left_out = 0; beside > 0 && left_out <= count; ++left_out) {
    const bool all = left_out == count;
    if (!all && (beside < 2 || holding[left_out].feature == TriangleFeature::kFace)) continue;
    std::array<FaceContact, 3> others;
    std::size_t other_count = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool is_left_out =
          i == left_out || (all && holding[i].feature != TriangleFeature::kFace);
      if (!is_left_out) others[other_count++] = holding[i];
    }
    if (slides_along(std::span(others).first(other_count), friction)) return true;
  }
  std::array<FaceContact, kMaxContactPlanes> around;
  const double around_m = kAroundPerStandOff * scale().stand_off_m;
  const std::size_t around_count = tracer_.contacts_around(proxy_, around_m, around);
  if constexpr (Friction::kHolds) {
    if (count > 1 && slides_past(std::span(around).first(around_count), friction)) return true;
  }
  if (is_vertex || beside > 0) {
    const std::size_t tried = std::min(around_count, kMostAtVertex);
    if (slides_at_vertex(std::span(around).first(tried), friction)) return true;
  }
  hold_again(std::span(holding).first(count), held);
  return false;
}

// Of two faces that friction would wedge the proxy between, one may not be touched yet: as far as
// to there, only the other one holds.
template <typename Friction>
bool GodObject::slides_up_to_what_holds(Friction& friction) {
  const PlaneProjection held = projection_;
  const auto count = static_cast<std::size_t>(held.active_count);
  std::array<FaceContact, 3> holding;
  std::array<FaceContact, 3> touched;
  std::array<Vec3, 3> normals;  // in the plane of motion, if there is one
  std::size_t touched_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    holding[i] = contacts_[held.active[i]];
    if (holding[i].clearance_m > scale().stand_off_m) continue;
    normals[touched_count] = plane_normal(i);
    touched[touched_count++] = holding[i];
  }
  if (touched_count == 0 || touched_count == count) return false;
  if (slides_along(std::span(touched).first(touched_count), friction)) return true;
  // Those that are touched, and not pressed, lead along them to the other.
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Vec3 lag = goal_ - proxy_;
  const auto leads_along = [&](const Vec3& along, const FaceContact& face) {
    const FrictionCone cone = friction.source->cone(friction.source->context, face, proxy_);
    const double held_m = cone.static_friction * (lag - along).norm();
    if (!(along.norm() > held_m)) return false;
    stop_at_first_hit(proxy_ + (1.0 - held_m / along.norm()) * along);
    if (leads_on(before)) return true;
    proxy_ = before;
    path_.resize(corners);
    return false;
  };
  for (std::size_t i = 0; i < touched_count; ++i) {
    if (leads_along(lag - lag.dot(normals[i]) * normals[i], touched[i])) return true;
  }
  if (touched_count == 2) {
    const Vec3 line = normals[0].cross(normals[1]);
    if (leads_along(lag.dot(line) / line.squaredNorm() * line, touched[0])) return true;
  }
  hold_again(std::span(holding).first(count), held);
  return false;
}

// Among many faces in a narrow groove, the two that hold the proxy may bear, wedged between them,
// more than any two that it would slide along. True if it goes on along all of them.
template <typename Friction>
bool GodObject::slides_past(std::span<const FaceContact> around, Friction& friction) {
  std::array<FaceContact, kMaxContactPlanes> nearest;
  for (std::size_t i = 0; i < around.size(); ++i) {
    nearest[i] = tracer_.nearest_contact(around[i].face, proxy_);
  }
  return slides_along(std::span(nearest).first(around.size()), friction);
}

// Tries the faces around a vertex: each alone, each two, and each two from above both, where the
// proxy is beside a crease that it could follow and lower than it may be over one of its sides.
template <typename Friction>
bool GodObject::slides_at_vertex(std::span<const FaceContact> around, Friction& friction) {
  for (std::size_t i = 0; i < around.size(); ++i) {
    const FaceContact alone[] = {around[i]};
    if (slides_along(alone, friction)) return true;
    for (std::size_t j = 0; j < i; ++j) {
      const FaceContact pair[] = {around[i], around[j]};
      if (slides_along(pair, friction)) return true;
      const bool is_low = std::min(pair[0].clearance_m, pair[1].clearance_m) < scale().stop_m;
      if (is_low && lifts_and_slides(pair, around, friction)) return true;
    }
  }
  return false;
}

// Lifts the proxy above both faces, nearer to none of those around, and lets it slide along them;
// true if all that led on by more than little.
template <typename Friction>
bool GodObject::lifts_and_slides(std::span<const FaceContact> pair,
                                 std::span<const FaceContact> around, Friction& friction) {
  const Vec3 lift = lift_above(pair, around);
  if (lift.isZero(0.0) || tracer_.trace(proxy_, proxy_ + lift)) return false;
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Friction friction_before = friction;
  commit(proxy_ + lift);
  std::array<FaceContact, 2> above;
  for (std::size_t i = 0; i < 2; ++i) {
    above[i] = tracer_.contact_over(pair[i].face, proxy_, pair[i].normal);
  }
  if (slides_along(above, friction) && leads_on(before)) return true;
  friction = friction_before;
  proxy_ = before;
  path_.resize(corners);
  return false;
}

// Takes a step held by these planes alone; true if it led on by more than little.
template <typename Friction>
bool GodObject::slides_along(std::span<const FaceContact> contacts, Friction& friction) {
  plane_count_ = 0;
  for (const FaceContact& contact : contacts) add_plane(contact);
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Friction friction_before = friction;
  take_step(friction);
  if (leads_on(before)) {
    if constexpr (Friction::kHolds) friction.end_step(true);
    return true;
  }
  friction = friction_before;
  proxy_ = before;
  path_.resize(corners);
  return false;
}

}  // namespace palpate
