#include "engine/simulation/contour_path.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/mesh/collinear_runs.h"

namespace palpate {
namespace {

// The free distance in front of the contour, as a multiple of the clearance: the hand needs as much
// behind it.
constexpr double kRoomBehind = 2.0;

// The largest number of segments tested for the opening.
constexpr std::size_t kMostOpenings = 64;

// The angle from one direction to the other, positive to the left seen from the tip of
// plane_normal.
double turn(const Vec3& from, const Vec3& to, const Vec3& plane_normal) {
  return std::atan2(from.cross(to).dot(plane_normal), from.dot(to));
}

// The length of a ray in the plane up to a segment; at most `most`.
double free_length(const Vec3& from, const Vec3& direction, const Vec3& a, const Vec3& b,
                   const Vec3& plane_normal, double most) {
  const Vec3 along = b - a;
  const double det = direction.cross(along).dot(plane_normal);
  if (det == 0.0) return most;
  const Vec3 to_a = a - from;
  const double distance = to_a.cross(along).dot(plane_normal) / det;
  const double part = to_a.cross(direction).dot(plane_normal) / det;
  return distance > 0.0 && part >= 0.0 && part <= 1.0 ? std::min(distance, most) : most;
}

// The same for all segments of all curves except the segment that begins at but_from.
double free_length(const Vec3& from, const Vec3& direction, const std::vector<Polyline>& curves,
                   const Vec3& plane_normal, const Vec3& but_from, double most) {
  double length = most;
  for (const Polyline& curve : curves) {
    const std::vector<Vec3>& points = curve.points_m;
    const std::size_t segments = points.size() - (curve.closed ? 0 : 1);
    for (std::size_t i = 0; i < segments; ++i) {
      if (points[i] == but_from) continue;
      length = free_length(from, direction, points[i], points[(i + 1) % points.size()],
                           plane_normal, length);
    }
  }
  return length;
}

}  // namespace

std::vector<Vec3> open_contour(const Polyline& contour, const std::vector<Polyline>& curves,
                               const Vec3& plane_normal, double& room_m) {
  std::vector<Vec3> points = contour.points_m;
  if (!contour.closed) {
    const Vec3 leg = points[1] - points[0];
    const Vec3 first = points[0] + std::min(0.25, 0.5 * room_m / leg.norm()) * leg;
    const Vec3 outward = leg.cross(plane_normal).normalized();
    const double wanted_m = kRoomBehind * room_m;
    const double free_m = free_length(first, outward, curves, plane_normal, points[0], wanted_m);
    room_m = std::min(room_m, free_m / kRoomBehind);
    return points;
  }
  const std::size_t n = points.size();
  const auto next = [n](std::size_t i) { return (i + 1) % n; };
  std::vector<std::size_t> by_length(n);
  std::iota(by_length.begin(), by_length.end(), std::size_t{0});
  std::stable_sort(by_length.begin(), by_length.end(), [&](std::size_t a, std::size_t b) {
    return (points[next(a)] - points[a]).norm() > (points[next(b)] - points[b]).norm();
  });
  const double wanted_m = kRoomBehind * room_m;
  std::size_t best = by_length.front();
  double most_m = -1.0;
  for (std::size_t k = 0; k < std::min(n, kMostOpenings) && most_m < wanted_m; ++k) {
    const std::size_t i = by_length[k];
    const Vec3 middle = 0.5 * (points[i] + points[next(i)]);
    const Vec3 outward = (points[next(i)] - points[i]).cross(plane_normal).normalized();
    const double free_m = free_length(middle, outward, curves, plane_normal, points[i], wanted_m);
    if (free_m <= most_m) continue;
    most_m = free_m;
    best = i;
  }
  room_m = std::min(room_m, most_m / kRoomBehind);
  const Vec3 middle = 0.5 * (points[best] + points[next(best)]);
  std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(next(best)),
              points.end());
  points.insert(points.begin(), middle);
  points.push_back(middle);
  return points;
}

// A simplified contour that turns back may be a spike or a slit. The turn of the full contour at
// that point distinguishes them.
HandPath contour_path(const std::vector<Vec3>& whole_m, const Vec3& plane_normal,
                      double tolerance_m) {
  std::vector<Vec3> contour_m = without_collinear_points(whole_m, false, plane_normal, tolerance_m);
  if (contour_m.size() < 2) contour_m = whole_m;
  HandPath path;
  std::size_t in_whole = 0;
  const std::size_t last = contour_m.size() - 1;
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < last; ++i) {
    const Vec3 tangent = (contour_m[i + 1] - contour_m[i]).normalized();
    double fold_rad = 0.0;
    if (i > 0) {
      do ++in_whole;
      while (in_whole + 2 < whole_m.size() && whole_m[in_whole] != contour_m[i]);
      fold_rad = turn(before, tangent, plane_normal);
      if (std::abs(fold_rad) > kTurnsBackRad) {
        fold_rad =
            std::copysign(fold_rad, turn(whole_m[in_whole] - whole_m[in_whole - 1],
                                         whole_m[in_whole + 1] - whole_m[in_whole], plane_normal));
      }
    }
    path.points.push_back({contour_m[i], plane_normal.cross(tangent), fold_rad});
    before = tangent;
  }
  path.points.push_back({contour_m[last], path.points.back().inward});
  return path;
}

}  // namespace palpate
