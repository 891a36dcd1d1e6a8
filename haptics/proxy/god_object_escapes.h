#pragma once

// Attempts to improve the position of a proxy that planes hold, as templates over the friction
// policy. An attempt succeeds if it brings the proxy nearer to the goal by more than
// GodObject::little_m(); otherwise it is undone. Private to the files god_object*.cpp.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "haptics/proxy/god_object_lines.h"
#include "haptics/proxy/god_object_steps.h"
#include "haptics/proxy/god_object_surroundings.h"

namespace palpate {

// The largest number of faces around a vertex along which slides are tried, singly and in pairs.
constexpr std::size_t kMostAtVertex = 12;

// The largest number of bends of a path past the faces near the proxy.
constexpr int kMostBends = 8;

// The largest number of halvings of the angle between a blocked and a free direction. Twelve
// halvings reduce the angle to 1/4096.
constexpr int kMostDirectionHalvings = 12;

// Number of planes added one after the other when many may hold the proxy.
constexpr int kMostExchanges = 64;

// Up to three faces.
struct GodObject::Faces {
  std::array<FaceContact, 3> contacts;
  std::size_t count = 0;

  void add(const FaceContact& contact) { contacts[count++] = contact; }
  std::span<FaceContact> all() { return std::span(contacts).first(count); }
  std::span<const FaceContact> all() const { return std::span(contacts).first(count); }
};

// Determines the planes that hold the proxy among any number of contacts: while planes are
// violated, the most violated plane is added.
template <typename Friction>
void GodObject::hold_by_most_violated(const Friction& friction,
                                      std::span<const FaceContact> contacts) {
  step_.clear_planes();
  step_.solve(project(friction, {}));
  for (int left = kMostExchanges; left > 0; --left) {
    tracer_.count(Work::kPlane, contacts.size() + step_.planes().size());
    const FaceContact* most = nullptr;
    double by_m = 0.0;
    for (const FaceContact& contact : contacts) {
      const double room_m = std::max(0.0, contact.clearance_m - scale().stop_m);
      const double violation_m = -room_m - contact.normal.dot(step_.displacement_m());
      if (violation_m <= by_m) continue;
      by_m = violation_m;
      most = &contact;
    }
    if (!most || !add_plane(*most)) return;
    step_.solve(project(friction, step_.planes()));
    if (!step_.is_solved()) return;
  }
}

// Whether the faces that hold a point prove that it is at rest: the steepest descent that
// approaches none of them gains too little. The test permits approaches within rounding, since such
// steps can lead far between nearly parallel faces.
template <typename Friction>
bool GodObject::is_held_by(const Friction& friction, std::span<const FaceContact> holding) const {
  std::array<ContactPlane, 3> planes;
  for (std::size_t i = 0; i < holding.size(); ++i) {
    if (!is_touched_face(holding[i])) return false;
    planes[i] = {plane_normal(i), -place_roundoff_m()};
  }
  const PlaneProjection descent = project(friction, std::span(planes).first(holding.size()));
  return descent.solved && !may_gain_by(friction, descent.displacement_m);
}

// As is_held_by(), for all touched faces. The search for the holding faces may end with a subset,
// which permits a larger gain.
template <typename Friction>
bool GodObject::is_held_by_faces(const Friction& friction) {
  hold_by_faces(friction);
  return step_.is_solved() && !may_gain_by(friction, step_.displacement_m());
}

// Determines the planes that hold a point among those of the touched faces that it is over.
template <typename Friction>
void GodObject::hold_by_faces(const Friction& friction) {
  auto& faces = around_->scratch;
  std::size_t count = 0;
  for (const FaceContact& contact : around_->all_touched()) {
    if (!is_touched_face(contact)) continue;
    faces[count] = contact;
    faces[count++].clearance_m = scale().stop_m + place_roundoff_m();
  }
  hold_by_most_violated(friction, std::span(faces).first(count));
}

// As is_held_by_faces(), under friction. An edge of another face may touch the point, too; it bears
// no part of the lag, since the faces alone keep the point. So they replace the contacts that held
// it. kMoved: the point slid along these faces, however little, so that its lag is on their cone.
// kStuck: they neither hold the point nor let it slide.
template <typename Friction>
GodObject::Progress GodObject::rests_or_slides_on_faces(Friction& friction) {
  const Friction before = friction;
  hold_by_faces(friction);
  if (!step_.is_solved() || step_.active_count() == 0) return Progress::kStuck;
  const bool holds = hold_by(friction);
  const bool is_above_cone =
      holds && friction.wants_to_slide && !has_converged(step_.displacement_m());
  const bool gains = may_gain_by(friction, step_.displacement_m());
  friction.end_step(false);
  if (!gains && !is_above_cone) {
    for (int i = 0; i < step_.active_count(); ++i) {
      FaceContact& contact = step_.active_contact(i);
      contact = tracer_.contact_over(contact.face, proxy_, contact.normal);
    }
    return Progress::kHeld;
  }
  friction = before;
  const Vec3 from = proxy_;
  take_step(friction);
  if (proxy_ != from) {
    friction.end_step(true);
    return Progress::kMoved;
  }
  friction = before;
  return Progress::kStuck;
}

// Tries to improve the position of a proxy that planes hold.
//
// A point beside a triangle is held by the plane, an edge or a vertex of the triangle. If an
// adjacent triangle continues the surface and lies under the point, the contact with the first
// triangle must not hold the point. Therefore, before the point counts as resting, the solver tries
// to move it without each such contact. At a vertex, the free space is not convex, and other faces
// can leave a gap. There the solver tries slides along all near faces, along each face and along
// each pair of faces, and then past the obstacle that such a slide meets. Last, it tries to pass
// the edges and corners that the point does not touch. If two nearly parallel faces are closer to
// each other than the proxy may come to either, rounding decides whether an attempt succeeds. A
// stuck point can be nearer to its own face than it may come to the next face; the edge of the next
// face then blocks it.
template <typename Friction>
[[gnu::cold]] GodObject::Escape GodObject::leaves_edges(Progress progress, Friction& friction) {
  if constexpr (Friction::kHolds) {
    if (slides_up_to_untouched_face(friction)) return Escape::kLeft;
  }
  if (tracer_.radius_m() > 0.0) return leaves_wedge(friction);
  const Faces holding = holding_faces();
  if (!Friction::kHolds && is_held_by(friction, holding.all())) return Escape::kNone;
  const bool is_stuck = progress == Progress::kStuck;
  const bool is_beside =
      is_stuck || std::any_of(holding.all().begin(), holding.all().end(), is_beside_face);
  if (!is_beside && holding.count < 2) return Escape::kNone;
  const ProxyPlace here = place_now();
  look_around();
  if constexpr (Friction::kHolds) {
    if (!tracer_.is_cut_short()) {
      const Progress on_faces = rests_or_slides_on_faces(friction);
      if (on_faces == Progress::kMoved) return Escape::kLeft;
      if (on_faces == Progress::kHeld) return Escape::kNone;
    }
  }
  if (tracer_.is_cut_short() || (!Friction::kHolds && is_held_by_faces(friction))) {
    return_to(here);
    return Escape::kNone;
  }
  const bool is_vertex = is_at_vertex(holding.all());
  if (is_beside && slides_without_edges(holding, friction)) return Escape::kLeft;
  if (slides_past(friction)) return Escape::kLeft;
  const Escape between = slides_between(friction);
  if (between == Escape::kLeft) return between;
  if ((is_beside || is_vertex) && slides_at_vertex(friction)) return Escape::kLeft;
  if constexpr (!Friction::kHolds) {
    if ((is_beside || is_vertex) && goes_past_obstacles(friction)) return Escape::kLeft;
    if (is_vertex && goes_along_lines(friction)) return Escape::kLeft;
    if (goes_past_edges(friction)) return Escape::kLeft;
  }
  return_to(here);
  return between;
}

// Tries to free a sphere that friction wedges between several faces, by sliding along one or two of
// them.
template <typename Friction>
GodObject::Escape GodObject::leaves_wedge(Friction& friction) {
  Escape between = Escape::kNone;
  if constexpr (Friction::kHolds) {
    if (step_.active_count() < 2) return between;
    const ProxyPlace here = place_now();
    look_around();
    if (!tracer_.is_cut_short()) between = slides_between(friction);
    if (between != Escape::kLeft) return_to(here);
  }
  return between;
}

// A contact beside a face is a contact with an edge or vertex of the face. Tries three kinds of
// slides: with each such contact replaced by the contact with the face's nearest point, then
// without one of these contacts, and last without any of them.
template <typename Friction>
bool GodObject::slides_without_edges(const Faces& holding, Friction& friction) {
  Faces nearest = holding;
  Faces over;
  for (FaceContact& contact : nearest.all()) {
    if (is_beside_face(contact)) {
      contact = tracer_.nearest_contact(contact.face, proxy_);
    } else {
      over.add(contact);
    }
  }
  if (slides_along(nearest.all(), friction)) return true;
  const std::size_t beside = holding.count - over.count;
  for (std::size_t left_out = 0; beside > 1 && left_out < holding.count; ++left_out) {
    if (!is_beside_face(holding.contacts[left_out])) continue;
    Faces others;
    for (std::size_t i = 0; i < holding.count; ++i) {
      if (i != left_out) others.add(holding.contacts[i]);
    }
    if (slides_along(others.all(), friction)) return true;
  }
  return slides_along(over.all(), friction);
}

// Tries to slide up to a face that the proxy does not touch yet. During this slide, only the
// touched faces hold the proxy by friction.
template <typename Friction>
bool GodObject::slides_up_to_untouched_face(Friction& friction) {
  Faces touched;
  std::array<Vec3, 3> normals;  // in the plane of motion, if there is one
  const auto count = static_cast<std::size_t>(step_.active_count());
  for (std::size_t i = 0; i < count; ++i) {
    const FaceContact& contact = step_.active_contact(i);
    if (contact.clearance_m > scale().stand_off_m) continue;
    normals[touched.count] = plane_normal(i);
    touched.add(contact);
  }
  if (touched.count == 0 || touched.count == count) return false;
  const ProxyPlace here = place_now();
  if (slides_along(touched.all(), friction)) return true;
  // Touched faces that bear no load still guide the proxy towards the other face.
  const Vec3 lag = goal_ - proxy_;
  for (std::size_t i = 0; i < touched.count; ++i) {
    const Vec3 along = lag - lag.dot(normals[i]) * normals[i];
    if (slides_by(along, touched.contacts[i], friction)) return true;
  }
  if (touched.count == 2) {
    const Vec3 line = crossing_line(normals[0], normals[1]);
    if (slides_by(lag.dot(line) * line, touched.contacts[0], friction)) return true;
  }
  return_to(here);
  return false;
}

// Tries a slide along one component of the lag, shortened by the friction of this face.
template <typename Friction>
bool GodObject::slides_by(const Vec3& along, const FaceContact& face, Friction& friction) {
  if (!may_gain_by(friction, along)) return false;
  return tries(friction, [&] {
    friction.begin_step();
    friction.cone = friction.source->cones.at(face, proxy_);
    friction.shares = 1.0;
    const double lag_m = along.norm();
    const double depth_m = (goal_ - proxy_ - along).norm();
    friction.compare(lag_m, depth_m);
    const double part = friction.part_left(lag_m, depth_m);
    stop_at_first_hit(end_of_step(part * along));
  });
}

// Tries to slide along all near faces, each represented by the plane of its nearest point, and
// along the faces that this slide meets.
template <typename Friction>
bool GodObject::slides_past(Friction& friction) {
  hold_by_most_violated(friction, around_->all_nearest());
  return tries(friction, [&] {
    for (int bend = 0; bend < kMostBends; ++bend) {
      if (take_step(friction) != Progress::kStopped) break;
    }
  });
}

// Tries to slide along one or two touched faces, or along an edge of one, in directions that
// approach no other touched face. The proxy may be held by two other faces, between which friction
// wedges it.
template <typename Friction>
GodObject::Escape GodObject::slides_between(Friction& friction) {
  const auto all_touched = around_->all_touched();
  const auto touched = all_touched.first(std::min(all_touched.size(), kMostCrossing));
  tracer_.count(Work::kPlane, touched.size() * touched.size() / 2);
  const Vec3 lag = goal_ - proxy_;
  Escape blocked = Escape::kNone;
  const auto leads_on = [&](const Vec3& step, std::span<const FaceContact> along) {
    if (tracer_.is_cut_short()) return false;
    if (!may_gain_by(friction, step) || !falls_to_none(step, all_touched)) return false;
    if (follows(step, along, friction)) return true;
    const Vec3 shortened = step_.displacement_m();  // the step, shortened by friction
    if (may_gain_by(friction, shortened) && is_stopped_by_rounding(shortened)) {
      blocked = Escape::kRoundingDecides;
    }
    return false;
  };
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const std::optional<Vec3> n = in_motion_plane(touched[i].normal);
    if (!n) continue;
    const FaceContact alone[] = {touched[i]};
    if (leads_on(friction.within(lag, *n), alone)) return Escape::kLeft;
    if (touched[i].feature == TriangleFeature::kEdge && !motion_plane_) {
      const Vec3 edge = tracer_.edge_direction(touched[i]);
      if (leads_on(friction.along(lag, edge), alone)) return Escape::kLeft;
    }
    for (std::size_t j = 0; j < i && !motion_plane_; ++j) {
      const FaceContact pair[] = {touched[i], touched[j]};
      const Vec3 line = crossing_line(*n, touched[j].normal);
      if (leads_on(friction.along(lag, line), pair)) return Escape::kLeft;
    }
  }
  return blocked;
}

// Tries the given step instead of the step that the planes of these contacts would give. During the
// step, the contacts hold the proxy.
template <typename Friction>
bool GodObject::follows(const Vec3& step, std::span<const FaceContact> contacts,
                        Friction& friction) {
  step_.clear_planes();
  for (const FaceContact& contact : contacts) add_plane(contact);
  step_.solve_by_all(step);
  return tries(friction, [&] {
    if constexpr (Friction::kHolds) hold_by(friction);
    stop_at_first_hit(end_of_step(step_.displacement_m()));
  });
}

// Tries the steepest descent that the touched faces allow. If an obstacle blocks this direction,
// the plane of the obstacle is added. The added plane gives a new direction. Directions between the
// blocked one and the new one are then tried, because they may lead past the obstacle.
template <typename Friction>
bool GodObject::goes_past_obstacles(Friction& friction) {
  std::array<FaceContact, kMostAround + kMostBends> walls;
  std::size_t count = around_->touched_count;
  std::copy_n(around_->nearest.begin(), count, walls.begin());
  for (FaceContact& wall : std::span(walls).first(count)) wall.clearance_m = scale().stop_m;
  Vec3 blocked = Vec3::Zero();
  for (int bend = 0; bend < kMostBends; ++bend) {
    hold_by_most_violated(friction, std::span(walls).first(count));
    const Vec3 free = step_.displacement_m();
    if (bend > 0 && goes_between(blocked, free, friction)) return true;
    if (!may_gain_by(friction, free)) return false;
    std::optional<TraceHit> hit;
    if (goes_straight(free, friction, &hit)) return true;
    if (!hit) return false;
    walls[count] = hit->contact;
    walls[count++].clearance_m = scale().stop_m;
    blocked = free;
  }
  return false;
}

// Tries, by bisection, directions between a blocked direction and one that is free or gains too
// little.
template <typename Friction>
bool GodObject::goes_between(Vec3 blocked, Vec3 free, Friction& friction) {
  for (int i = 0; i < kMostDirectionHalvings; ++i) {
    const Vec3 direction = (blocked + free).normalized();
    const Vec3 middle = friction.along(goal_ - proxy_, direction);
    if (!may_gain_by(friction, middle)) {
      free = middle;
    } else if (goes_straight(middle, friction)) {
      return true;
    } else {
      blocked = middle;
    }
  }
  return false;
}

// Tries one straight step. Writes the first obstacle of the step, or nullopt, to `obstacle`. Most
// such steps are blocked at once; the trace before the attempt detects this and saves time.
template <typename Friction>
bool GodObject::goes_straight(const Vec3& step, Friction& friction,
                              std::optional<TraceHit>* obstacle) {
  if (tracer_.is_cut_short()) return false;
  const Vec3 target = end_of_step(step);
  const auto hit = tracer_.trace(proxy_, target);
  if (obstacle) *obstacle = hit;
  if (hit && !may_gain_by(friction, hit->fraction.value() * (target - proxy_))) return false;
  return tries(friction, [&] { stop_at_first_hit(target); });
}

// Tries to slide along each face around a vertex and along each pair of faces. If the proxy is
// nearer to one face of a pair than it may be, the function also lifts it above both faces and then
// tries the slide. Such a proxy may be beside a crease between the two faces; it can follow this
// crease.
template <typename Friction>
bool GodObject::slides_at_vertex(Friction& friction) {
  const auto is_low = [&](const FaceContact& face) { return face.clearance_m < scale().stop_m; };
  const auto faces = around_->all_faces().first(std::min(around_->count, kMostAtVertex));
  const auto nearest = around_->all_nearest().first(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const FaceContact alone[] = {faces[i]};
    if (slides_along(alone, friction)) return true;
    for (std::size_t j = 0; j < i; ++j) {
      const FaceContact pair[] = {faces[i], faces[j]};
      if (slides_along(pair, friction)) return true;
      if (!is_low(pair[0]) && !is_low(pair[1])) continue;
      if (lifts_and_slides(pair, nearest, friction)) return true;
    }
  }
  return false;
}

// Tries to lift the proxy above both faces, without approaching any face around it, and to slide
// along the two faces. The lift may lead away from the goal. The path then leaves it out: it leads
// straight to the first point of the slide that is no farther from the goal than the proxy, and on
// to the end of the slide; or straight to this end. The attempt fails if neither path is free.
template <typename Friction>
bool GodObject::lifts_and_slides(std::span<const FaceContact> pair,
                                 std::span<const FaceContact> nearest, Friction& friction) {
  const Vec3 before = proxy_;
  const Vec3 lifted = before + lift_above(pair, nearest);
  if (lifted == before || tracer_.trace(before, lifted)) return false;
  return tries(friction, [&] {
    const std::size_t corners = path_.size();
    commit(lifted);
    step_.set_earlier();
    Faces above;
    for (const FaceContact& face : pair) {
      above.add(tracer_.contact_over(face.face, proxy_, face.normal));
    }
    if (!slides_along(above.all(), friction)) return;
    const Vec3 first = first_no_farther(friction, before, lifted, proxy_);
    if (first == lifted) return;
    const Vec3 end = std::exchange(proxy_, before);
    path_.resize(corners);
    if (tracer_.trace(before, first) || tracer_.trace(first, end)) {
      if (tracer_.trace(before, end)) return;
    } else {
      commit(first);
    }
    commit(end);
  });
}

// The first point of the segment between two points that is no farther from the goal than `than`,
// by bisection. The end `to` must be such a point.
template <typename Friction>
Vec3 GodObject::first_no_farther(const Friction& friction, const Vec3& than, const Vec3& from,
                                 const Vec3& to) const {
  const double most_m = friction.length(than - goal_);
  const auto is_farther = [&](const Vec3& p) { return friction.length(p - goal_) > most_m; };
  if (!is_farther(from)) return from;
  double farther = 0.0;
  double nearer = 1.0;
  const auto at = [&](double part) -> Vec3 {
    return part == 1.0 ? to : Vec3(from + part * (to - from));
  };
  for (int i = 0; i < std::numeric_limits<double>::digits; ++i) {
    const double middle = 0.5 * (farther + nearer);
    (is_farther(at(middle)) ? farther : nearer) = middle;
  }
  return at(nearer);
}

// Tries a step in which only these contacts hold the proxy.
template <typename Friction>
bool GodObject::slides_along(std::span<const FaceContact> contacts, Friction& friction) {
  step_.clear_planes();
  for (const FaceContact& contact : contacts) add_plane(contact);
  return tries(friction, [&] { take_step(friction); });
}

// Executes `step`. Returns true if it brought the proxy nearer to the goal by more than little_m().
// Otherwise restores position, path and friction state, but not the planes.
template <typename Friction, typename Step>
bool GodObject::tries(Friction& friction, Step step) {
  if (tracer_.is_cut_short()) return false;
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Friction friction_before = friction;
  step();
  if (is_gain(friction, before, proxy_)) {
    if constexpr (Friction::kHolds) friction.end_step(true);
    return true;
  }
  friction = friction_before;
  proxy_ = before;
  path_.resize(corners);
  return false;
}

}  // namespace palpate
