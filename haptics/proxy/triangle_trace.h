#pragma once

// How far a proxy can move before it meets one triangle. Frame of the triangle, metres.

#include <cmath>

#include "geometry/base/types.h"
#include "geometry/exact/fraction.h"
#include "geometry/exact/orientation.h"
#include "geometry/exact/triangle.h"

namespace palpate {

// Of the whole step of a proxy that is traced, from p to q.
using StepFraction = FractionOf<struct TracedStep>;

// Where a step of the proxy is stopped by one triangle.
struct TriangleHit {
  Vec3 normal;         // unit, from the triangle to the proxy
  double clearance_m;  // between the proxy's surface and the triangle at the stopping point
  StepFraction fraction = StepFraction::start();       // up to the stopping point
  StepFraction meet_fraction = StepFraction::start();  // up to the meeting
  TriangleFeature feature;
  Vec3 feature_point;  // the point of the triangle that is met
};

// What a trace of one triangle has cost, counted for WorkMeter.
struct TriangleWork {
  SignWork signs;
  int nearest_points = 0;
};

// Distances that keep a proxy on its side. See SolverScale.
struct TraceMargins {
  double stop_m;
  double clearance_m;
};

// Beside a triangle, but rather over it than beside: the direction from its nearest point to p is
// less than 60 degrees from its normal. Such a point is held by the plane of the triangle.
inline bool is_rather_over(const TriangleGeometry& t, const Vec3& direction) noexcept {
  return std::abs(t.normal.dot(direction)) >= 0.5;
}

// Point proxy from p to q; it is stopped at stop_m from the triangle, or where it is if that is
// nearer. A step that passes the triangle by but ends within the clearance of it is stopped, too.
// Returns false if neither is so. Adds to `work` what that took. Whether it crosses, and from which
// side, is exact for the very doubles p and q.
bool trace_point(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                 const TraceMargins& margins, TriangleHit& hit, TriangleWork& work) noexcept;

// Sphere of radius_m > 0 whose centre goes from p to q; stopped when radius_m + stop_m
// from the triangle. A sphere that already overlaps the triangle may leave it or keep its distance,
// but not come nearer.
//
// The distance to a triangle is convex along the step, so Newton's iteration from the start never
// passes the first contact: each tangent lies below the distance, and a tangent that stays above
// the target to the end of the step proves that there is no contact. Tangents are taken as much
// steeper as the rounding of their direction could have hidden: for spheres next to nothing in
// size, that is what counts.
//
// Contacts beyond `limit` are of no interest and need not be found.
bool trace_sphere(const TriangleGeometry& t, const Vec3& p, const Vec3& q, double radius_m,
                  double stop_m, StepFraction limit, TriangleHit& hit, TriangleWork& work) noexcept;

}  // namespace palpate
