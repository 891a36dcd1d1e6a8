#include "geometry/triangle.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

TrianglePoint closest_point_on_edge(const Vec3& from, const Vec3& to, const Vec3& p) {
  const Vec3 along = to - from;
  const double t = (p - from).dot(along) / along.squaredNorm();
  if (t <= 0.0) return {from, (p - from).norm(), TriangleFeature::kVertex};
  if (t >= 1.0) return {to, (p - to).norm(), TriangleFeature::kVertex};
  // From the nearer end, so that the rounding of t * along stays small next to it.
  const Vec3 q = t < 0.5 ? Vec3(from + t * along)
                         : Vec3(to - ((to - p).dot(along) / along.squaredNorm()) * along);
  return {q, (p - q).norm(), TriangleFeature::kEdge};
}

}  // namespace

bool prism_contains(const TriangleGeometry& t, const Vec3& p) {
  return t.normal.cross(t.b - t.a).dot(p - t.a) >= 0.0 &&
         t.normal.cross(t.c - t.b).dot(p - t.b) >= 0.0 &&
         t.normal.cross(t.a - t.c).dot(p - t.c) >= 0.0;
}

TrianglePoint closest_point_on_triangle(const TriangleGeometry& t, const Vec3& p) noexcept {
  if (prism_contains(t, p)) {
    const double height = t.normal.dot(p - t.a);
    return {p - height * t.normal, std::abs(height), TriangleFeature::kFace};
  }
  TrianglePoint nearest = closest_point_on_edge(t.a, t.b, p);
  for (const auto& [from, to] : {std::pair(&t.b, &t.c), std::pair(&t.c, &t.a)}) {
    const TrianglePoint candidate = closest_point_on_edge(*from, *to, p);
    if (candidate.distance < nearest.distance) nearest = candidate;
  }
  return nearest;
}

}  // namespace palpate
