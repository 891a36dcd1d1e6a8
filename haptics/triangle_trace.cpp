#include "haptics/triangle_trace.h"

#include <algorithm>
#include <cmath>

#include "geometry/segment_triangle.h"

namespace palpate {
namespace {

// Newton doubles its digits except where the sphere grazes the triangle, where it gains one bit a
// step; a step not decided after 53 of them is stopped where it is, which is safe.
constexpr int kMaxNewtonSteps = 53;

void stop_before(double meet_fraction, double approach_per_step, double back_off_m,
                 TriangleHit& hit) {
  hit.meet_fraction = meet_fraction;
  hit.fraction = std::max(0.0, meet_fraction - back_off_m / approach_per_step);
}

// A step that passes the triangle by: is its end too close?
bool stop_near_end(const TriangleGeometry& t, const Vec3& p, const Vec3& d,
                   const TraceMargins& margins, TriangleHit& hit) {
  const Vec3 end = p + d;
  if (std::abs(t.normal.dot(end - t.a)) >= margins.clearance_m) return false;
  const TrianglePoint nearest = closest_point_on_triangle(t, end);
  if (nearest.distance >= margins.clearance_m) return false;
  if (trace_sphere(t, p, d, margins.clearance_m, margins.stand_off_m, hit)) return true;
  // So close to an edge, directions have few digits, and Newton may have been led past the contact.
  // The end is too close all the same: a stand-off less is tried.
  hit = {
      nearest.direction, nearest.distance, std::max(0.0, 1.0 - margins.stand_off_m / d.norm()), 1.0,
      nearest.feature,   nearest.point};
  return true;
}

}  // namespace

bool trace_point(const TriangleGeometry& t, const Vec3& p, const Vec3& d,
                 const TraceMargins& margins, TriangleHit& hit) noexcept {
  const SegmentCrossing crossing = cross_segment(t, p, d);
  if (crossing.kind == SegmentCrossing::Kind::kMiss) {
    return stop_near_end(t, p, d, margins, hit);
  }
  double height = crossing.height_start;
  hit.normal = height < 0.0 ? Vec3(-t.normal) : t.normal;
  hit.feature = TriangleFeature::kFace;
  if (crossing.kind == SegmentCrossing::Kind::kEdgeOn) {
    hit.normal = crossing.edge_normal;
    hit.feature = TriangleFeature::kEdge;
    height = hit.normal.dot(p - crossing.edge_point);
  }
  height = std::abs(height);
  const double approach = -hit.normal.dot(d);
  if (approach <= 0.0) return false;  // leaves the face, or keeps its height over it
  hit.feature_point = p + crossing.fraction * d;
  stop_before(std::min(1.0, height / approach), approach, margins.stand_off_m, hit);
  hit.clearance_m = height - hit.fraction * approach;
  return true;
}

bool trace_sphere(const TriangleGeometry& t, const Vec3& p, const Vec3& d, double radius_m,
                  double stand_off_m, TriangleHit& hit) noexcept {
  // A hit is coming within half the stand-off: a sphere that was stopped at the full one can slide
  // along without being stopped again by rounding.
  double target = radius_m + 0.5 * stand_off_m;
  const double height_start = t.normal.dot(p - t.a);
  const double height_end = height_start + t.normal.dot(d);
  if (std::min(height_start, height_end) > target || std::max(height_start, height_end) < -target) {
    return false;
  }
  double fraction = 0.0;
  for (int step = 0; step <= kMaxNewtonSteps; ++step) {
    const Vec3 centre = p + fraction * d;
    const TrianglePoint nearest = closest_point_on_triangle(t, centre);
    if (step == 0) target = std::min(target, nearest.distance);
    hit.normal = nearest.direction;
    const double approach = -hit.normal.dot(d);
    // Below the rounding of the distance, an approach over the whole step is none.
    const double roundoff = kHeightRoundoff * (nearest.distance + d.lpNorm<1>());
    if (approach <= (nearest.distance <= target ? roundoff : 0.0)) return false;
    const double ahead = (nearest.distance - target) / approach;
    const bool met = nearest.distance - target <= 0.125 * stand_off_m;
    if (!met && step < kMaxNewtonSteps) {
      if (fraction + ahead > 1.0) return false;
      fraction += ahead;
      continue;
    }
    // At or within an eighth of the stand-off of the target; is it going to be passed at all?
    if (fraction + ahead > 1.0) return false;
    hit.feature = nearest.feature;
    hit.feature_point = nearest.point;
    stop_before(fraction, approach, radius_m + stand_off_m - nearest.distance, hit);
    hit.clearance_m = nearest.distance - radius_m + (hit.meet_fraction - hit.fraction) * approach;
    return true;
  }
  return false;
}

}  // namespace palpate
