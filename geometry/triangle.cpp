#include "geometry/triangle.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

TrianglePoint at(const Vec3& q, const Vec3& p, TriangleFeature feature, const Vec3& normal) {
  const Vec3 apart = p - q;
  const double distance = apart.norm();
  return {q, distance, distance > 0.0 ? Vec3(apart / distance) : normal, feature};
}

TrianglePoint closest_point_on_edge(const Vec3& from, const Vec3& to, const Vec3& p,
                                    const Vec3& normal) {
  const Vec3 along = to - from;
  const double t = (p - from).dot(along) / along.squaredNorm();
  if (t <= 0.0) return at(from, p, TriangleFeature::kVertex, normal);
  if (t >= 1.0) return at(to, p, TriangleFeature::kVertex, normal);
  // From the nearer end, so that the rounding of t * along stays small next to it.
  const Vec3 q = t < 0.5 ? Vec3(from + t * along)
                         : Vec3(to - ((to - p).dot(along) / along.squaredNorm()) * along);
  return at(q, p, TriangleFeature::kEdge, normal);
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
    return {p - height * t.normal, std::abs(height), height < 0.0 ? Vec3(-t.normal) : t.normal,
            TriangleFeature::kFace};
  }
  TrianglePoint nearest = closest_point_on_edge(t.a, t.b, p, t.normal);
  for (const auto& [from, to] : {std::pair(&t.b, &t.c), std::pair(&t.c, &t.a)}) {
    const TrianglePoint candidate = closest_point_on_edge(*from, *to, p, t.normal);
    if (candidate.distance < nearest.distance) nearest = candidate;
  }
  return nearest;
}

}  // namespace palpate
