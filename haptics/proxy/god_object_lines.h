#pragma once

// Attempts to move a proxy that planes hold along the lines in which two planes intersect: those
// of the faces around a vertex, and those past edges and corners that the proxy does not touch.
// Templates over the friction policy, private to the files god_object*.cpp; see
// god_object_escapes.h.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "haptics/proxy/god_object_surroundings.h"

namespace palpate {

// The number of planes past the nearest edges that are intersected with all planes past edges. More
// would make a rest beside a stack of sheets expensive.
constexpr std::size_t kMostPassed = 12;

// The largest angle, rad, by which rounding may turn the line in which two planes intersect: half
// the digits of double.
constexpr double kLineRoundoff = 1e-8;

// Tries to slide along the lines in which any two planes around a vertex intersect, whether or not
// the proxy touches their faces. The planes are those of the faces and those of their nearest
// points. The longest step is tried first, because it gains most, and because the free line around
// a hub of hundreds of triangles may be late in the original order.
template <typename Friction>
bool GodObject::goes_along_lines(Friction& friction) {
  if (motion_plane_) return false;
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
  tracer_.count(Work::kPlane, count * count / 2);
  around_->line_count = 0;
  const Vec3 lag = goal_ - proxy_;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      add_line(friction.along(lag, crossing_line(normals[i], normals[j])), friction);
    }
  }
  return goes_along_longest(friction);
}

// Tries to pass the edges and corners near the point that it does not touch. A face stops every
// step that would come nearer to its edge, although a step at a small angle to this one passes the
// edge at a stand-off, and the plane of the face may lead away from the goal.
template <typename Friction>
bool GodObject::goes_past_edges(Friction& friction) {
  around_->line_count = 0;
  add_lines_past_edges(friction);
  add_lines_past_corners(friction);
  return goes_along_longest(friction);
}

// Three planes through the point belong to an edge: two pass it at a stand-off, and one keeps the
// distance from it. Adds the steepest descent in each of these planes, and the lines in which they
// intersect the planes of touched faces and those of the nearest edges.
template <typename Friction>
void GodObject::add_lines_past_edges(const Friction& friction) {
  std::array<Vec3, kMostPlanes> normals;
  std::size_t count = 0;
  const auto add = [&](const Vec3& direction) {
    const std::optional<Vec3> normal = in_motion_plane(direction);
    const auto end = normals.begin() + static_cast<std::ptrdiff_t>(count);
    if (!normal || count == kMostPlanes || std::find(normals.begin(), end, *normal) != end) return;
    normals[count++] = *normal;
  };
  for (const FaceContact& contact : around_->all_untouched()) {
    if (contact.feature != TriangleFeature::kEdge) continue;
    const double cosine = scale().stand_off_m / contact.clearance_m;
    const double sine = std::sqrt(1.0 - cosine * cosine);
    const Vec3 across = tracer_.edge_direction(contact).cross(contact.normal);
    add(contact.normal);
    add(cosine * contact.normal + sine * across);
    add(cosine * contact.normal - sine * across);
  }
  const std::size_t past_count = count;
  for (const FaceContact& contact : around_->all_touched()) add(contact.normal);
  const Vec3 lag = goal_ - proxy_;
  for (std::size_t i = 0; i < past_count; ++i) {
    add_line(friction.within(lag, normals[i]), friction);
    for (std::size_t j = i + 1; j < count && !motion_plane_; ++j) {
      if (j >= kMostPassed && j < past_count) continue;
      add_line(friction.along(lag, crossing_line(normals[i], normals[j])), friction);
    }
  }
}

// The directions that pass a corner at a stand-off form a cone. Adds the one that leads most
// directly to the goal, and those along the planes of touched faces.
template <typename Friction>
void GodObject::add_lines_past_corners(const Friction& friction) {
  const Vec3 lag = goal_ - proxy_;
  for (const FaceContact& contact : around_->all_untouched()) {
    if (contact.feature != TriangleFeature::kVertex) continue;
    const double sine = scale().stand_off_m / contact.clearance_m;
    const double cosine = std::sqrt(1.0 - sine * sine);
    const auto add_within = [&](const Vec3& normal) {
      const Vec3 out = contact.normal - contact.normal.dot(normal) * normal;
      const double nearer = cosine / out.norm();
      if (!(nearer < 1.0)) return;  // no direction in this plane leads nearer to the corner
      const Vec3 u = out.normalized();
      const Vec3 aside = std::sqrt(1.0 - nearer * nearer) * normal.cross(u);
      add_line(friction.along(lag, aside - nearer * u), friction);
      add_line(friction.along(lag, -aside - nearer * u), friction);
    };
    if (motion_plane_) {
      add_within(motion_plane_->normal());
      continue;
    }
    add_within(lag.cross(contact.normal).normalized());
    for (const FaceContact& touched :
         around_->all_touched().first(std::min(around_->touched_count, kMostCrossing))) {
      add_within(touched.normal);
    }
  }
}

// Adds a step to the lines to be tried, unless it gains too little or approaches a touched face.
template <typename Friction>
void GodObject::add_line(const Vec3& step, const Friction& friction) {
  Surroundings& around = *around_;
  if (around.line_count == kMostLines || !may_gain_by(friction, step)) return;
  if (!falls_to_none(step, around.all_touched())) return;
  around.lines[around.line_count] = {step, step.norm(), around.line_count};
  ++around.line_count;
}

// Tries the steps along the lines that were added, the longest first.
template <typename Friction>
bool GodObject::goes_along_longest(Friction& friction) {
  const auto lines = std::span(around_->lines).first(around_->line_count);
  std::sort(lines.begin(), lines.end(), [](const LineStep& a, const LineStep& b) {
    return std::pair(-a.length_m, a.order) < std::pair(-b.length_m, b.order);
  });
  return std::any_of(lines.begin(), lines.end(),
                     [&](const LineStep& line) { return goes_along_line(line.step, friction); });
}

// Tries a step along a line. Because of rounding, the line of two nearly parallel planes may run
// into a face that it should pass. In this case, a step along that face is tried.
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

}  // namespace palpate
