#include "haptics/proxy/triangle_trace.h"

#include <algorithm>
#include <cmath>

#include "geometry/exact/segment_triangle.h"

namespace palpate {
namespace {

// Newton doubles its digits except where the sphere grazes the triangle, where it gains one bit a
// step; a step not decided after 53 of them is stopped where it is, which is safe.
constexpr int kMaxNewtonSteps = 53;

// A point beside a triangle is stopped within so much more of the distance at which it is to stop.
constexpr double kMetPerStop = 1.0 / 64;

// Stops back_off_m before the meeting, measured along the normal; where the step hardly approaches
// the triangle, that is where it is.
void stop_before(double meet_fraction, double approach_per_step, double back_off_m,
                 TriangleHit& hit) {
  hit.meet_fraction = StepFraction(meet_fraction);
  hit.fraction = hit.meet_fraction;
  if (back_off_m <= 0.0) return;
  hit.fraction = StepFraction(approach_per_step > 0.0
                                  ? std::max(0.0, meet_fraction - back_off_m / approach_per_step)
                                  : 0.0);
}

// A step that crosses the triangle, but comes to it past an edge: a height says nothing about how
// far the triangle is there. Stops where the distance is stop_m, or at the start if that is nearer,
// by Newton's iteration as in trace_sphere(). False if the distance does not fall, to within
// rounding.
bool stop_beside(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double stop_m,
                 TriangleHit& hit, TriangleWork& work) {
  const Vec3 d = q - p;
  double fraction = 0.0;
  for (int step = 0;; ++step) {
    const TrianglePoint nearest = closest_point_on_triangle(t, p + fraction * d);
    ++work.nearest_points;
    const double approach = -nearest.direction.dot(d);
    if (approach <= 0.0) return false;
    const double room = nearest.distance - stop_m;
    if (room > kMetPerStop * stop_m && step < kMaxNewtonSteps) {
      fraction += room / approach;
      if (fraction > 1.0) return false;
      continue;
    }
    hit.normal = nearest.direction;
    hit.clearance_m = nearest.distance;
    hit.fraction = hit.meet_fraction = StepFraction(fraction);
    hit.feature = nearest.feature;
    hit.feature_point = nearest.point;
    return true;
  }
}

// A step that passes the triangle by: is its end too close?
bool stop_near_end(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double height_end,
                   const TraceMargins& margins, TriangleHit& hit, TriangleWork& work) {
  if (std::abs(height_end) >= margins.clearance_m) return false;
  const TrianglePoint nearest = closest_point_on_triangle(t, q);
  ++work.nearest_points;
  if (nearest.distance >= margins.clearance_m) return false;
  if (stop_beside(t, p, q, margins.stop_m, hit, work)) return true;
  // So close to an edge, directions have few digits, and Newton may have been led past the contact.
  // The end is too close all the same: a little less is tried.
  hit.normal = nearest.direction;
  hit.clearance_m = nearest.distance;
  hit.meet_fraction = StepFraction::end();
  hit.fraction = StepFraction(std::max(0.0, 1.0 - margins.stop_m / (q - p).norm()));
  hit.feature = nearest.feature;
  hit.feature_point = nearest.point;
  return true;
}

}  // namespace

bool trace_point(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                 const TraceMargins& margins, TriangleHit& hit, TriangleWork& work) noexcept {
  const SegmentCrossing crossing = cross_segment(t, p, q);
  work.signs = crossing.signs;
  double height = 0.0;
  double approach = 0.0;
  switch (crossing.kind) {
    case SegmentCrossing::Kind::kMiss:
      return stop_near_end(t, p, q, crossing.height_end, margins, hit, work);
    case SegmentCrossing::Kind::kWithin:
      return false;  // it was put there: it may leave to either side
    case SegmentCrossing::Kind::kThrough:
      hit.normal = crossing.side < 0 ? Vec3(-t.normal) : t.normal;
      hit.feature = TriangleFeature::kFace;
      height = crossing.side * crossing.height_start;
      approach = crossing.side * (crossing.height_start - crossing.height_end);
      break;
    case SegmentCrossing::Kind::kEdgeOn:
      hit.normal = crossing.edge_normal;
      hit.feature = TriangleFeature::kEdge;
      height = hit.normal.dot(p - crossing.edge_point);
      approach = -hit.normal.dot(q - p);
      break;
  }
  // A crossing is certain, even where rounding hides that the step comes nearer.
  hit.feature_point = p + crossing.fraction * (q - p);
  stop_before(crossing.fraction, approach, margins.stop_m, hit);
  hit.clearance_m = height - hit.fraction.value() * approach;
  const Vec3 stop = p + hit.fraction.value() * (q - p);
  if (prism_contains(t, stop)) return true;
  const TrianglePoint nearest = closest_point_on_triangle(t, stop);
  ++work.nearest_points;
  TriangleHit beside;
  if (is_rather_over(t, nearest.direction)) {
    hit.feature = nearest.feature;
  } else if (stop_beside(t, p, q, margins.stop_m, beside, work)) {
    hit = beside;
  }
  return true;
}

bool trace_sphere(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double radius_m,
                  double stop_m, StepFraction limit, TriangleHit& hit,
                  TriangleWork& work) noexcept {
  const Vec3 d = q - p;
  // A hit is coming within half the distance: a sphere that was stopped at the full one can slide
  // along without being stopped again by rounding.
  double target = radius_m + 0.5 * stop_m;
  const double height_start = t.normal.dot(p - t.a);
  const double height_end = t.normal.dot(q - t.a);
  const double apart = target + kHeightRoundoff * (norm1(p - t.a) + norm1(d));
  if (std::min(height_start, height_end) > apart || std::max(height_start, height_end) < -apart) {
    return false;
  }
  const double length = d.norm();
  double fraction = 0.0;
  for (int step = 0;; ++step) {
    const TrianglePoint nearest = closest_point_on_triangle(t, p + fraction * d);
    ++work.nearest_points;
    if (step == 0) target = std::min(target, nearest.distance);
    const double room = nearest.distance - target;
    const double approach = -nearest.direction.dot(d);
    // What the direction's rounding can hide.
    const double doubt =
        nearest.direction_error_rad * length + kHeightRoundoff * (nearest.distance + length);
    // Where it overlaps already, keeping the distance to within rounding is allowed.
    if (approach <= (room <= 0.0 ? doubt : -doubt)) return false;
    const double ahead = room / (approach + doubt);
    if (fraction + ahead > 1.0) return false;
    const bool met = room <= 0.125 * stop_m;
    if (!met && step < kMaxNewtonSteps) {
      fraction += ahead;
      // Only where it has not met yet: of two that meet at once neither may hide the other.
      if (fraction > limit.value()) return false;
      continue;
    }
    hit.normal = nearest.direction;
    hit.feature = nearest.feature;
    hit.feature_point = nearest.point;
    stop_before(fraction, approach, radius_m + stop_m - nearest.distance, hit);
    hit.clearance_m = nearest.distance - radius_m + (fraction - hit.fraction.value()) * approach;
    return true;
  }
}

}  // namespace palpate
