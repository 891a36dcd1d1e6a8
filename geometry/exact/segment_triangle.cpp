#include "geometry/exact/segment_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

// The sign of a computed value with a bound on its rounding error; 0 if it is undecided.
int certain_sign(double value, double bound) {
  return value > bound ? 1 : value < -bound ? -1 : 0;
}

// The side of the plane of t on which p lies, if double cannot decide it: 1 in front.
int exact_side(const TriangleGeometry& t, const Vec3& p, SignWork& work) {
  return orientation_in_doubt(t.a, t.b, t.c, p, work);
}

// The sides on which the line from p to q passes the edges ab, bc, ca.
std::array<int, 3> line_sides(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                              SignWork& work) {
  const Vec3 d = q - p;
  const Vec3 a = t.a - p;
  const Vec3 b = t.b - p;
  const Vec3 c = t.c - p;
  const double scale = kTripleRoundoff * norm1(d);
  const double size_a = norm1(a);
  const double size_b = norm1(b);
  const double size_c = norm1(c);
  std::array<int, 3> sides = {certain_sign(triple_product(d, a, b), scale * size_a * size_b),
                              certain_sign(triple_product(d, b, c), scale * size_b * size_c),
                              certain_sign(triple_product(d, c, a), scale * size_c * size_a)};
  // Two certain sides that differ decide that the line misses the triangle.
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  if (*least * *most < 0) return sides;
  if (sides[0] == 0) sides[0] = orientation_in_doubt(p, q, t.a, t.b, work);
  if (sides[1] == 0) sides[1] = orientation_in_doubt(p, q, t.b, t.c, work);
  if (sides[2] == 0) sides[2] = orientation_in_doubt(p, q, t.c, t.a, work);
  return sides;
}

// An exact test whether a coplanar segment and triangle meet. They are apart if the line along one
// of their edges separates them. The sides of this line are tested with the plane through the line
// and a point outside the common plane.
bool meets_in_plane(const TriangleGeometry& t, const Vec3& p, const Vec3& q, SignWork& work) {
  int axis = 0;
  t.normal.cwiseAbs().maxCoeff(&axis);
  const auto off_plane = [axis](const Vec3& from, const Vec3& to) {
    Vec3 point = from;
    point[axis] += (to - from).cwiseAbs().maxCoeff();
    return point;
  };
  const std::array<const Vec3*, 5> corners = {&t.a, &t.b, &t.c, &t.a, &t.b};
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3& from = *corners[e];
    const Vec3& to = *corners[e + 1];
    const Vec3 off = off_plane(from, to);
    const auto side = [&](const Vec3& r) { return orientation(from, to, off, r, work); };
    const int inside = side(*corners[e + 2]);
    if (side(p) * inside < 0 && side(q) * inside < 0) return false;
  }
  const Vec3 off = off_plane(p, q);
  const auto side = [&](const Vec3& corner) { return orientation(p, q, off, corner, work); };
  const int a = side(t.a);
  return a == 0 || side(t.b) != a || side(t.c) != a;
}

// The segment lies in the plane of the triangle to the last bit: clips it against the three edges
// and reports the entry point, up to rounding.
void cross_in_plane(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                    SegmentCrossing& crossing) {
  if (!meets_in_plane(t, p, q, crossing.signs)) return;
  double enter = 0.0;
  bool from_outside = false;
  const std::array<const Vec3*, 4> corners = {&t.a, &t.b, &t.c, &t.a};
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3 outward = (*corners[e + 1] - *corners[e]).cross(t.normal).normalized();
    const double start = outward.dot(p - *corners[e]);
    const double end = outward.dot(q - *corners[e]);
    const double slope = end - start;
    if (start > 0.0 && slope < 0.0) {
      const double at = std::min(1.0, start / -slope);
      if (!from_outside || at > enter) {
        enter = at;
        from_outside = true;
        crossing.edge_normal = outward;
        crossing.edge_point = *corners[e];
      }
    }
  }
  crossing.kind = from_outside ? SegmentCrossing::Kind::kEdgeOn : SegmentCrossing::Kind::kWithin;
  crossing.fraction = enter;
}

}  // namespace

SegmentCrossing cross_segment(const TriangleGeometry& t, const Vec3& p, const Vec3& q) noexcept {
  SegmentCrossing crossing;
  const Vec3 to_p = p - t.a;
  const Vec3 to_q = q - t.a;
  crossing.height_start = t.normal.dot(to_p);
  crossing.height_end = t.normal.dot(to_q);
  const double bound_start = kHeightRoundoff * norm1(to_p);
  const double bound_end = kHeightRoundoff * norm1(to_q);
  int start = certain_sign(crossing.height_start, bound_start);
  int end = certain_sign(crossing.height_end, bound_end);
  if (start * end > 0) return crossing;
  // The line is tested first: it decides most of the remaining cases without the exact sides.
  const std::array<int, 3> sides = line_sides(t, p, q, crossing.signs);
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  if (*least * *most < 0) return crossing;
  if (start == 0) start = exact_side(t, p, crossing.signs);
  if (end == 0) end = exact_side(t, q, crossing.signs);
  if (start * end > 0) return crossing;
  if (start == 0 && end == 0) {
    cross_in_plane(t, p, q, crossing);
    return crossing;
  }
  crossing.kind = start == 0 ? SegmentCrossing::Kind::kWithin : SegmentCrossing::Kind::kThrough;
  crossing.side = start;
  const double drop = crossing.height_start - crossing.height_end;
  crossing.fraction =
      start == 0 || drop == 0.0 ? 0.0 : std::clamp(crossing.height_start / drop, 0.0, 1.0);
  return crossing;
}

}  // namespace palpate
