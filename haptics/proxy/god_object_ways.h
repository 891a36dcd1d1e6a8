#pragma once

// Whether anything leads on from where planes hold the proxy, for the files that move it with and
// without friction.

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "haptics/proxy/god_object_steps.h"

namespace palpate {

// Creases beside a vertex are tried between so many faces.
constexpr std::size_t kMostAtVertex = 12;

// How far from what holds a proxy faces are looked at: flat ones that meet at a vertex come apart
// only many stand-offs from it.
constexpr double kAroundPerStandOff = 64.0;

// So many of them have the lines tried in which their planes cross.
constexpr std::size_t kMostCrossing = 32;

// The planes that they have: of faces, and of what is nearest of each. Any two may cross.
constexpr std::size_t kMostPlanes = 2 * kMostCrossing;
constexpr std::size_t kMostLines = kMostPlanes * (kMostPlanes - 1) / 2;

// How far such a line may turn by rounding: half the digits of double.
constexpr double kLineRoundoff = 1e-8;

// Faces near a proxy that are looked at.
constexpr std::size_t kMostAround = 256;

// How often a way past them may bend.
constexpr int kMostBends = 8;

// How often a way between one that is blocked and one that is not is halved: to a 4,000th.
constexpr int kMostWayHalvings = 12;

// A few faces.
struct GodObject::Faces {
  std::array<FaceContact, 3> contacts;
  std::size_t count = 0;

  void add(const FaceContact& contact) { contacts[count++] = contact; }
  std::span<FaceContact> all() { return std::span(contacts).first(count); }
  std::span<const FaceContact> all() const { return std::span(contacts).first(count); }
};

// The lag's part along the line in which two planes cross.
struct LineStep {
  Vec3 step;
  double length_m;
  std::size_t order;  // among all of them
};

// What is around a proxy that planes hold, the nearest first. Large, so it is made once.
struct GodObject::Surroundings {
  std::array<FaceContact, kMostAround> faces;    // as planes
  std::array<FaceContact, kMostAround> nearest;  // as the plane of what is nearest of each
  std::array<FaceContact, kMostAround> scratch;
  std::optional<Vec3> of;  // where the proxy was
  std::size_t count = 0;
  std::size_t touched_count = 0;  // the first so many
  std::array<LineStep, kMostLines> lines;

  std::span<const FaceContact> all_faces() const { return std::span(faces).first(count); }
  std::span<const FaceContact> all_nearest() const { return std::span(nearest).first(count); }
  std::span<const FaceContact> all_touched() const {
    return std::span(nearest).first(touched_count);
  }
};

// A point beside a triangle is held by its plane, or by its edge or vertex, also where another
// triangle goes on beyond and is what the point is over. Before it is said to rest there, it tries
// without each such contact. At a vertex the room is not convex, and other faces can leave a way on
// between them: it tries to go along all that is near, along each one and each two, and past what
// it meets then. True if any of that led on. Between faces that are nearly parallel, and nearer to
// each other than a proxy may come, rounding decides whether anything would. One that is stuck may
// be lower over its face than it may come to be over the next one, the edge of which is in its way.
template <typename Friction>
[[gnu::cold]] bool GodObject::leaves_edges(Progress progress, Friction& friction) {
  rounding_decides_ = false;
  if constexpr (Friction::kHolds) {
    if (slides_up_to_what_holds(friction)) return true;
  }
  if (tracer_.radius_m() > 0.0) return leaves_wedge(friction);
  const Faces holding = holding_faces();
  if (!Friction::kHolds && is_held_by(holding.all())) return false;
  const bool is_stuck = progress == Progress::kStuck;
  const bool is_beside =
      is_stuck || std::any_of(holding.all().begin(), holding.all().end(), is_beside_face);
  if (!is_beside && holding.count < 2) return false;
  const bool is_vertex = holding.count > 1 && is_at_vertex(holding.all());
  const ProxyPlace here = place_now();
  look_around();
  if (tracer_.is_cut_short() || is_held_by_faces()) {
    return_to(here);
    return false;
  }
  if (is_beside && slides_without_edges(holding, friction)) return true;
  if (slides_past(friction) || slides_between(friction)) return true;
  if ((is_beside || is_vertex) && slides_at_vertex(friction)) return true;
  if constexpr (!Friction::kHolds) {
    if ((is_beside || is_vertex) && goes_past_obstacles(friction)) return true;
    if (is_vertex && goes_along_lines(friction)) return true;
  }
  return_to(here);
  return false;
}

// Friction may wedge a sphere between faces that bear it together, though along one of them, or
// two, it would slide.
template <typename Friction>
bool GodObject::leaves_wedge(Friction& friction) {
  if constexpr (Friction::kHolds) {
    if (projection_.active_count < 2) return false;
    const ProxyPlace here = place_now();
    look_around();
    if (!tracer_.is_cut_short() && slides_between(friction)) return true;
    return_to(here);
  }
  return false;
}

// Takes each contact beside a face for what is nearest of the face, and then leaves them out, each
// alone and all.
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

// Of the faces that friction would wedge the proxy between, one may not be touched yet: as far as
// to there, only the others hold.
template <typename Friction>
bool GodObject::slides_up_to_what_holds(Friction& friction) {
  Faces touched;
  std::array<Vec3, 3> normals;  // in the plane of motion, if there is one
  const auto count = static_cast<std::size_t>(projection_.active_count);
  for (std::size_t i = 0; i < count; ++i) {
    const FaceContact& contact = contacts_[projection_.active[i]];
    if (contact.clearance_m > scale().stand_off_m) continue;
    normals[touched.count] = plane_normal(i);
    touched.add(contact);
  }
  if (touched.count == 0 || touched.count == count) return false;
  const ProxyPlace here = place_now();
  if (slides_along(touched.all(), friction)) return true;
  // Those that are touched, and not pressed, lead along them to the other.
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

// Goes along a part of the lag as far as the friction of this face leaves it.
template <typename Friction>
bool GodObject::slides_by(const Vec3& along, const FaceContact& face, Friction& friction) {
  if (!may_gain_by(along)) return false;
  return tries(friction, [&] {
    friction.begin_step();
    friction.cone = friction.source->cones.at(face, proxy_);
    const double part = friction.part_left(along.norm(), (goal_ - proxy_ - along).norm());
    stop_at_first_hit(within_bounds(proxy_ + part * along));
  });
}

// Goes on along all that is near, each as the plane of what is nearest of it, and along what it
// meets then.
template <typename Friction>
bool GodObject::slides_past(Friction& friction) {
  hold_by_most_violated(around_->all_nearest());
  return tries(friction, [&] {
    for (int bend = 0; bend < kMostBends; ++bend) {
      if (take_step(friction) != Progress::kStopped) break;
    }
  });
}

// Goes on along one or two of those that it touches, or an edge of one, where that falls towards no
// other. What holds the proxy may be two faces that bear more, wedged between them by friction.
template <typename Friction>
bool GodObject::slides_between(Friction& friction) {
  const auto all_touched = around_->all_touched();
  const auto touched = all_touched.first(std::min(all_touched.size(), kMostCrossing));
  const Vec3 lag = goal_ - proxy_;
  const auto leads_on = [&](const Vec3& step, std::span<const FaceContact> along) {
    if (tracer_.is_cut_short()) return false;
    if (!may_gain_by(step) || !falls_to_none(step, all_touched)) return false;
    if (follows(step, along, friction)) return true;
    const Vec3 way = projection_.displacement_m;  // what friction leaves of the step
    if (may_gain_by(way) && is_stopped_by_rounding(way)) rounding_decides_ = true;
    return false;
  };
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const std::optional<Vec3> n = in_motion_plane(touched[i].normal);
    if (!n) continue;
    const FaceContact alone[] = {touched[i]};
    if (leads_on(lag - lag.dot(*n) * *n, alone)) return true;
    if (touched[i].feature == TriangleFeature::kEdge && !motion_plane_normal_) {
      const Vec3 edge = tracer_.edge_direction(touched[i]);
      if (leads_on(lag.dot(edge) * edge, alone)) return true;
    }
    for (std::size_t j = 0; j < i && !motion_plane_normal_; ++j) {
      const FaceContact pair[] = {touched[i], touched[j]};
      const Vec3 line = crossing_line(*n, touched[j].normal);
      if (leads_on(lag.dot(line) * line, pair)) return true;
    }
  }
  return false;
}

// Takes a step along these contacts, wherever else their planes would lead.
template <typename Friction>
bool GodObject::follows(const Vec3& step, std::span<const FaceContact> contacts,
                        Friction& friction) {
  plane_count_ = 0;
  for (const FaceContact& contact : contacts) add_plane(contact);
  projection_ = {step, {0, 1, 2}, plane_count_, true};
  return tries(friction, [&] {
    if constexpr (Friction::kHolds) hold_by(friction);
    stop_at_first_hit(within_bounds(proxy_ + projection_.displacement_m));
  });
}

// Goes down as steeply as what it touches leaves it, and where an obstacle is met at once, as what
// that leaves, too: or between the two ways, past the obstacle.
template <typename Friction>
bool GodObject::goes_past_obstacles(Friction& friction) {
  std::array<FaceContact, kMostAround + kMostBends> walls;
  std::size_t count = around_->touched_count;
  std::copy_n(around_->nearest.begin(), count, walls.begin());
  for (FaceContact& wall : std::span(walls).first(count)) wall.clearance_m = scale().stop_m;
  Vec3 blocked = Vec3::Zero();
  for (int bend = 0; bend < kMostBends; ++bend) {
    hold_by_most_violated(std::span(walls).first(count));
    const Vec3 free = projection_.displacement_m;
    if (bend > 0 && goes_between(blocked, free, friction)) return true;
    if (!may_gain_by(free)) return false;
    std::optional<TraceHit> hit;
    if (goes_straight(free, friction, &hit)) return true;
    if (!hit) return false;
    walls[count] = hit->contact;
    walls[count++].clearance_m = scale().stop_m;
    blocked = free;
  }
  return false;
}

// Goes along the line in which two planes around a vertex meet, touched or not: of faces, and of
// what is nearest of them. The longest step first, which gains most: at a hub of hundreds of
// triangles the one that is free may be late among them.
template <typename Friction>
bool GodObject::goes_along_lines(Friction& friction) {
  if (motion_plane_normal_) return false;
  std::array<Vec3, kMostPlanes> normals;
  std::size_t count = 0;
  const auto add = [&](const Vec3& normal) {
    const auto end = normals.begin() + static_cast<std::ptrdiff_t>(count);
    if (std::find(normals.begin(), end, normal) == end) normals[count++] = normal;
  };
  for (std::size_t i = 0; i < std::min(around_->count, kMostCrossing); ++i) {
    add(around_->faces[i].normal);
    add(around_->nearest[i].normal);
  }
  std::size_t line_count = 0;
  const Vec3 lag = goal_ - proxy_;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 line = crossing_line(normals[i], normals[j]);
      const Vec3 step = lag.dot(line) * line;
      if (!may_gain_by(step) || !falls_to_none(step, around_->all_touched())) continue;
      around_->lines[line_count] = {step, step.norm(), line_count};
      ++line_count;
    }
  }
  const auto lines = std::span(around_->lines).first(line_count);
  std::sort(lines.begin(), lines.end(), [](const LineStep& a, const LineStep& b) {
    return std::pair(-a.length_m, a.order) < std::pair(-b.length_m, b.order);
  });
  return std::any_of(lines.begin(), lines.end(),
                     [&](const LineStep& line) { return goes_along_line(line.step, friction); });
}

// The line of two planes that are nearly parallel is rounded, and may run into what it should pass:
// goes on along that.
template <typename Friction>
bool GodObject::goes_along_line(const Vec3& step, Friction& friction) {
  std::optional<TraceHit> hit;
  if (goes_straight(step, friction, &hit)) return true;
  if (!hit) return false;
  const double fall_m = -hit->contact.normal.dot(step);
  if (fall_m <= 0.0 || fall_m > kLineRoundoff * step.norm()) return false;
  const Vec3 beside = step + fall_m * hit->contact.normal;
  return falls_to_none(beside, around_->all_touched()) && goes_straight(beside, friction);
}

// Between a way that is blocked and one that is not, or does not lead on.
template <typename Friction>
bool GodObject::goes_between(Vec3 blocked, Vec3 free, Friction& friction) {
  for (int i = 0; i < kMostWayHalvings; ++i) {
    const Vec3 direction = (blocked + free).normalized();
    const Vec3 middle = direction.dot(goal_ - proxy_) * direction;
    if (!may_gain_by(middle)) {
      free = middle;
    } else if (goes_straight(middle, friction)) {
      return true;
    } else {
      blocked = middle;
    }
  }
  return false;
}

// Tells what is in the way, if anything is. Most such ways are blocked at once.
template <typename Friction>
bool GodObject::goes_straight(const Vec3& step, Friction& friction,
                              std::optional<TraceHit>* obstacle) {
  if (tracer_.is_cut_short()) return false;
  const Vec3 target = within_bounds(proxy_ + step);
  const auto hit = tracer_.trace(proxy_, target);
  if (obstacle) *obstacle = hit;
  if (hit && !may_gain_by(hit->fraction.value() * (target - proxy_))) return false;
  return tries(friction, [&] { stop_at_first_hit(target); });
}

// Tries the faces around a vertex: each alone, each two, and each two from above both, where the
// proxy is beside a crease that it could follow and lower than it may be over one of its sides.
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

// Lifts the proxy above both faces, nearer to none of those around, and lets it slide along them.
template <typename Friction>
bool GodObject::lifts_and_slides(std::span<const FaceContact> pair,
                                 std::span<const FaceContact> nearest, Friction& friction) {
  const Vec3 lift = lift_above(pair, nearest);
  if (lift.isZero(0.0) || tracer_.trace(proxy_, proxy_ + lift)) return false;
  return tries(friction, [&] {
    commit(proxy_ + lift);
    planes_are_current_ = false;
    Faces above;
    for (const FaceContact& face : pair) {
      above.add(tracer_.contact_over(face.face, proxy_, face.normal));
    }
    slides_along(above.all(), friction);
  });
}

// Takes a step held by these planes alone.
template <typename Friction>
bool GodObject::slides_along(std::span<const FaceContact> contacts, Friction& friction) {
  plane_count_ = 0;
  for (const FaceContact& contact : contacts) add_plane(contact);
  return tries(friction, [&] { take_step(friction); });
}

// True if what is done leads nearer to the goal by more than little; takes it back otherwise, but
// for planes.
template <typename Friction, typename Step>
bool GodObject::tries(Friction& friction, Step step) {
  if (tracer_.is_cut_short()) return false;
  const Vec3 before = proxy_;
  const std::size_t corners = path_.size();
  const Friction friction_before = friction;
  step();
  if (is_gain(before, proxy_)) {
    if constexpr (Friction::kHolds) friction.end_step(true);
    return true;
  }
  friction = friction_before;
  proxy_ = before;
  path_.resize(corners);
  return false;
}

}  // namespace palpate
