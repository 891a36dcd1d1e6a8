#pragma once

// Distance from a point to one triangle, robust on slivers.

#include <algorithm>

#include "geometry/base/types.h"

namespace palpate {

enum class TriangleFeature : std::uint8_t { kFace, kEdge, kVertex };

// A triangle with its unit normal (counter-clockwise from the front). Any frame, metres.
struct TriangleGeometry {
  Vec3 a, b, c;
  Vec3 normal;
};

struct TrianglePoint {
  Vec3 point;       // on the closed triangle
  double distance;  // from the query point, metres, >= 0
  // Unit vector from `point` to the query point. Above or below the face, it is exactly the
  // triangle's normal or its opposite, however near the query point is. Elsewhere, it is the
  // normalised difference of the points, which loses digits near an edge. If the two points
  // coincide, it is the triangle's normal.
  Vec3 direction;
  double direction_error_rad;  // bound on the rounding error of `direction`
  TriangleFeature feature = TriangleFeature::kFace;
};

// True iff the projection of p on the plane of t lies in the closed triangle, up to rounding.
inline bool prism_contains(const TriangleGeometry& t, const Vec3& p) noexcept {
  const double ab = triple_product(t.normal, t.b - t.a, p - t.a);
  const double bc = triple_product(t.normal, t.c - t.b, p - t.b);
  const double ca = triple_product(t.normal, t.a - t.c, p - t.c);
  return std::min(std::min(ab, bc), ca) >= 0.0;
}

// Whether p, seen along the normal, lies outside an edge by more than `distance`. If so, p is
// farther than `distance` from the triangle. The test rejects most distant triangles at a fraction
// of the cost of the nearest point.
inline bool is_far_beside(const TriangleGeometry& t, const Vec3& p, double distance) noexcept {
  const auto is_far = [&](const Vec3& from, const Vec3& to) {
    const Vec3 edge = to - from;
    const double inwards =
        triple_product(t.normal, edge, p - from);  // distance times the length of the edge
    return inwards < 0.0 && inwards * inwards > distance * distance * edge.squaredNorm();
  };
  return is_far(t.a, t.b) || is_far(t.b, t.c) || is_far(t.c, t.a);
}

// The point of the closed triangle nearest to p. The function determines the nearest feature by
// means of the given unit normal and in-plane edge normals. Barycentric coordinates would lose all
// digits on a sliver. Error: a few ulp of the largest coordinate difference. noexcept, no
// allocation.
TrianglePoint closest_point_on_triangle(const TriangleGeometry& t, const Vec3& p) noexcept;

}  // namespace palpate
