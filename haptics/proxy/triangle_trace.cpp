#include "haptics/proxy/triangle_trace.h"

#include <algorithm>
#include <cmath>

#include "geometry/exact/segment_triangle.h"

namespace palpate {
namespace {

// Newton's iteration doubles the number of exact digits in each step, except where the sphere
// grazes the triangle: there it gains one bit per step. If 53 iterations do not decide, the proxy
// is stopped at the last iterate, which is safe.
constexpr int kMaxNewtonSteps = 53;

// Tolerance of the stopping distance of a point beside a triangle, relative to that distance.
constexpr double kMetPerStop = 1.0 / 64;

// Sets the stop back_off_m before the meeting, measured along the normal. A step that hardly
// approaches the triangle is stopped at its start.
void stop_before(double meet_fraction, double approach_per_step, double back_off_m,
                 TriangleHit& hit) {
  hit.meet_fraction = StepFraction(meet_fraction);
  hit.fraction = hit.meet_fraction;
  if (back_off_m <= 0.0) return;
  hit.fraction = StepFraction(approach_per_step > 0.0
                                  ? std::max(0.0, meet_fraction - back_off_m / approach_per_step)
                                  : 0.0);
}

// Stops a step that crosses the triangle but reaches it past an edge, where the height over the
// plane is not the distance from the triangle. The step is stopped where the distance is stop_m, or
// at its start if that is nearer, by Newton's iteration as in trace_sphere(). False if the distance
// does not decrease.
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

// Stops a step that misses the triangle if its end is closer than the clearance.
bool stop_near_end(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double height_end,
                   const TraceMargins& margins, TriangleHit& hit, TriangleWork& work) {
  if (std::abs(height_end) >= margins.clearance_m) return false;
  const TrianglePoint nearest = closest_point_on_triangle(t, q);
  ++work.nearest_points;
  if (nearest.distance >= margins.clearance_m) return false;
  if (stop_beside(t, p, q, margins.stop_m, hit, work)) return true;
  // Very near an edge, directions have few exact digits, and Newton's iteration may have passed the
  // contact. The end is still too close, so the step is shortened by the stopping distance.
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
      return false;  // a point placed on the triangle may leave to either side
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
  // The crossing is certain, even if rounding hides that the step approaches the triangle.
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
  // A hit is an approach to within half of the stopping distance: a sphere stopped at the full
  // distance can then slide along without rounding stopping it again.
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
    // The largest approach that the rounding of the direction can hide.
    const double doubt =
        nearest.direction_error_rad * length + kHeightRoundoff * (nearest.distance + length);
    // A sphere that already overlaps may keep its distance to within rounding.
    if (approach <= (room <= 0.0 ? doubt : -doubt)) return false;
    const double ahead = room / (approach + doubt);
    if (fraction + ahead > 1.0) return false;
    const bool met = room <= 0.125 * stop_m;
    if (!met && step < kMaxNewtonSteps) {
      fraction += ahead;
      // Tested only before the meeting: of two triangles met at once, neither may hide the other.
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
