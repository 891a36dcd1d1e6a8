#pragma once

// Continuous collision detection for a proxy and one triangle: finds how far the proxy can move
// before it meets the triangle. All points, normals and lengths are in the frame and unit of the
// triangle given.

#include <cmath>

#include "geometry/base/types.h"
#include "geometry/exact/fraction.h"
#include "geometry/exact/orientation.h"
#include "geometry/exact/triangle.h"

namespace palpate {

// A fraction of the step from p to q that is traced.
using StepFraction = FractionOf<struct TracedStep>;

// The point at which one triangle stops a step of the proxy.
struct TriangleHit {
  Vec3 normal;         // unit, from the triangle to the proxy
  double clearance_m;  // from the triangle to the proxy's surface at the stopping point
  StepFraction fraction = StepFraction::start();       // up to the stopping point
  StepFraction meet_fraction = StepFraction::start();  // up to the point where they meet
  TriangleFeature feature;
  Vec3 feature_point;  // the point of the triangle that is met
};

// The operations that the trace of one triangle took, counted for WorkMeter.
struct TriangleWork {
  SignWork signs;
  int nearest_points = 0;
};

// The distances of SolverScale that keep a proxy on its side, in the unit of the triangle.
struct TraceMargins {
  double stop_m;
  double clearance_m;
};

// Whether a point beside a triangle counts as over it: the direction from the nearest point of the
// triangle to the point is at most 60 degrees from the normal or its opposite. The plane of the
// triangle holds such a point. direction: unit.
inline bool is_rather_over(const TriangleGeometry& t, const Vec3& direction) noexcept {
  return std::abs(t.normal.dot(direction)) >= 0.5;
}

// Traces a point proxy from p to q against one triangle. Returns true if the triangle stops the
// step, either because the step crosses the triangle or because it passes by and ends within
// margins.clearance_m of the triangle. The step is stopped margins.stop_m before the triangle, or
// at p if p is already nearer. Whether the step crosses, and from which side, is exact for the
// doubles p and q. Adds the operations to `work`. Safe on the haptic thread; thread-safe.
bool trace_point(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                 const TraceMargins& margins, TriangleHit& hit, TriangleWork& work) noexcept;

// Traces a sphere of radius_m > 0 whose centre moves from p to q. Returns true if the triangle
// stops the step. It stops the step where the centre is at a distance of radius_m + stop_m from the
// triangle. A sphere that already overlaps the triangle may leave it or keep its distance, but may
// not move nearer. Hits beyond `limit` need not be found. Adds the operations to `work`. Safe on
// the haptic thread; thread-safe.
//
// Method: Newton's iteration for the distance along the step. The distance to a triangle is convex
// along the step, so the iteration from the start never passes the first contact: each tangent lies
// below the distance. A tangent that stays above the target distance until the end of the step
// proves that there is no contact. Each tangent is made steeper by the largest slope that the
// rounding of its direction can hide; this addition matters for very small spheres.
bool trace_sphere(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double radius_m,
                  double stop_m, StepFraction limit, TriangleHit& hit, TriangleWork& work) noexcept;

}  // namespace palpate
