#include "geometry/segment_triangle.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {
namespace {

__extension__ using Wide = __float128;  // 113 bits; __extension__ silences -Wpedantic

double norm1(const Vec3& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

// Sign of (p + d - p) . ((from - p) x (to - p)), or 0 when 113 bits cannot tell either. One
// rounding of the difference of two doubles needs more than 113 bits only when they differ by 60
// binary orders of magnitude, and then it is 2^-113 of the larger.
int wide_triple_sign(const Vec3& p, const Vec3& d, const Vec3& from, const Vec3& to) {
  Wide u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = d[k];
    v[k] = static_cast<Wide>(from[k]) - p[k];
    w[k] = static_cast<Wide>(to[k]) - p[k];
  }
  const Wide terms[6] = {u[0] * v[1] * w[2],  u[1] * v[2] * w[0],  u[2] * v[0] * w[1],
                         -u[0] * v[2] * w[1], -u[1] * v[0] * w[2], -u[2] * v[1] * w[0]};
  Wide sum = 0;
  Wide magnitude = 0;
  for (const Wide& term : terms) {
    sum += term;
    magnitude += term < 0 ? -term : term;
  }
  // 12 roundings of 2^-113 each, as in kTripleRoundoff.
  const Wide bound = magnitude * static_cast<Wide>(12 * 0x1p-113);
  return sum > bound ? 1 : sum < -bound ? -1 : 0;
}

// On which side of the edge the line passes; 0 is "through it, or in doubt".
int line_side(const Vec3& p, const Vec3& d, const Vec3& from, const Vec3& to) {
  const Vec3 v = from - p;
  const Vec3 w = to - p;
  const double volume = d.dot(v.cross(w));
  const double bound = kTripleRoundoff * norm1(d) * norm1(v) * norm1(w);
  if (volume > bound) return 1;
  if (volume < -bound) return -1;
  return wide_triple_sign(p, d, from, to);
}

// The segment lies in the plane of the triangle, as far as rounding can tell: clips it against the
// three edges and reports where it comes in. A segment that starts inside has no edge to be
// stopped at and is reported as crossing at its start.
SegmentCrossing cross_in_plane(const TriangleGeometry& t, const Vec3& p, const Vec3& d) {
  SegmentCrossing crossing;
  double enter = 0.0;
  double leave = 1.0;
  bool from_outside = false;
  const std::array<const Vec3*, 4> corners = {&t.a, &t.b, &t.c, &t.a};
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3 outward = (*corners[e + 1] - *corners[e]).cross(t.normal).normalized();
    const double start = outward.dot(p - *corners[e]);
    const double slope = outward.dot(d);
    const double bound = kHeightRoundoff * (norm1(p - *corners[e]) + norm1(d));
    if (start > bound && start + slope > bound) return crossing;
    if (start > 0.0 && slope < 0.0) {
      const double at = std::min(1.0, start / -slope);
      if (!from_outside || at > enter) {
        enter = at;
        from_outside = true;
        crossing.edge_normal = outward;
        crossing.edge_point = *corners[e];
      }
    } else if (slope > 0.0) {
      leave = std::min(leave, std::max(0.0, -start / slope));
    }
  }
  if (enter > leave) return crossing;
  crossing.kind = from_outside ? SegmentCrossing::Kind::kEdgeOn : SegmentCrossing::Kind::kThrough;
  crossing.fraction = enter;
  return crossing;
}

}  // namespace

SegmentCrossing cross_segment(const TriangleGeometry& t, const Vec3& p, const Vec3& d) noexcept {
  SegmentCrossing crossing;
  const Vec3 to_p = p - t.a;
  const double height_start = t.normal.dot(to_p);
  const double height_end = height_start + t.normal.dot(d);
  const double bound = kHeightRoundoff * (norm1(to_p) + norm1(d));
  if (std::min(height_start, height_end) > bound || std::max(height_start, height_end) < -bound) {
    return crossing;
  }
  if (std::abs(height_start) <= bound && std::abs(height_end) <= bound) {
    crossing = cross_in_plane(t, p, d);
  } else {
    const int sides[3] = {line_side(p, d, t.a, t.b), line_side(p, d, t.b, t.c),
                          line_side(p, d, t.c, t.a)};
    const auto [least, most] = std::minmax_element(std::begin(sides), std::end(sides));
    if (*least < 0 && *most > 0) return crossing;
    crossing.kind = SegmentCrossing::Kind::kThrough;
    crossing.fraction = std::clamp(height_start / (height_start - height_end), 0.0, 1.0);
  }
  crossing.height_start = height_start;
  crossing.height_end = height_end;
  return crossing;
}

}  // namespace palpate
