#include "engine/contour_way.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace palpate {
namespace {

constexpr double kSharpCornerRad = std::numbers::pi / 4;

// A curve that turns by more turns back: which way round, its points alone do not tell.
constexpr double kTurnsBackRad = 0.95 * std::numbers::pi;

// So much of the room in front of a contour is behind the hand, too.
constexpr double kRoomBehind = 2.0;

// Segments that a contour is tried to be opened at.
constexpr std::size_t kMostOpenings = 64;

// From one direction to the other, to the left seen from the tip of plane_normal.
double turn(const Vec3& from, const Vec3& to, const Vec3& plane_normal) {
  return std::atan2(from.cross(to).dot(plane_normal), from.dot(to));
}

// How far a ray gets in the plane before it meets a segment; `most` if it does not.
double free_way(const Vec3& from, const Vec3& direction, const Vec3& a, const Vec3& b,
                const Vec3& plane_normal, double most) {
  const Vec3 along = b - a;
  const double det = direction.cross(along).dot(plane_normal);
  if (det == 0.0) return most;
  const Vec3 to_a = a - from;
  const double way = to_a.cross(along).dot(plane_normal) / det;
  const double part = to_a.cross(direction).dot(plane_normal) / det;
  return way > 0.0 && part >= 0.0 && part <= 1.0 ? std::min(way, most) : most;
}

// The same before all segments of all curves but one.
double free_way(const Vec3& from, const Vec3& direction, const std::vector<Polyline>& curves,
                const Vec3& plane_normal, const Vec3& but_from, double most) {
  double way = most;
  for (const Polyline& curve : curves) {
    const std::vector<Vec3>& points = curve.points_m;
    const std::size_t segments = points.size() - (curve.closed ? 0 : 1);
    for (std::size_t i = 0; i < segments; ++i) {
      if (points[i] == but_from) continue;
      way =
          free_way(from, direction, points[i], points[(i + 1) % points.size()], plane_normal, way);
    }
  }
  return way;
}

}  // namespace

std::vector<Vec3> open_contour(const Polyline& contour, const std::vector<Polyline>& curves,
                               const Vec3& plane_normal, double& room_m) {
  std::vector<Vec3> points = contour.points_m;
  if (!contour.closed) return points;
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
    const double free_m = free_way(middle, outward, curves, plane_normal, points[i], wanted_m);
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

ContourWay::ContourWay(const std::vector<Vec3>& contour_m, const std::vector<Vec3>& whole_m,
                       const Vec3& plane_normal, double press_depth_m, double side)
    : plane_normal_(plane_normal), depth_m_(press_depth_m), side_(side) {
  const auto tangent = [&](std::size_t i) {
    return Vec3((contour_m[i + 1] - contour_m[i]).normalized());
  };
  add(contour_m.front() + depth_m_ * inward_of(tangent(0)), 0.0);
  double along_m = 0.0;
  std::size_t in_whole = 0;
  for (std::size_t i = 1; i + 1 < contour_m.size(); ++i) {
    along_m += (contour_m[i] - contour_m[i - 1]).norm();
    do ++in_whole;
    while (in_whole + 2 < whole_m.size() && whole_m[in_whole] != contour_m[i]);
    double turn_rad = side_ * turn(tangent(i - 1), tangent(i), plane_normal_);
    if (std::abs(turn_rad) > kTurnsBackRad) {
      const Vec3 before = whole_m[in_whole] - whole_m[in_whole - 1];
      const Vec3 after = whole_m[in_whole + 1] - whole_m[in_whole];
      turn_rad = std::copysign(turn_rad, side_ * turn(before, after, plane_normal_));
    }
    add_corner(contour_m[i], tangent(i - 1), tangent(i), turn_rad, along_m);
  }
  const std::size_t last = contour_m.size() - 1;
  along_m += (contour_m[last] - contour_m[last - 1]).norm();
  add(contour_m[last] + depth_m_ * inward_of(tangent(last - 1)), along_m);
}

void ContourWay::add(const Vec3& p_m, double along_m, bool is_turn) {
  const double way_m =
      waypoints_.empty() ? 0.0 : waypoints_.back().way_m + (p_m - waypoints_.back().p_m).norm();
  waypoints_.push_back({p_m, along_m, way_m, is_turn});
}

void ContourWay::add_corner(const Vec3& corner_m, const Vec3& tangent_in, const Vec3& tangent_out,
                            double turn_rad, double along_m) {
  const Vec3 inward_in = inward_of(tangent_in);
  const Vec3 inward_out = inward_of(tangent_out);
  if (turn_rad >= kSharpCornerRad) {
    add(corner_m + depth_m_ * (inward_in + tangent_in), along_m, true);
    // Of what is thinner than the depth it goes on along the front: inside is the other side.
    if (turn_rad > kTurnsBackRad) {
      add(corner_m + depth_m_ * (2.0 * tangent_out - inward_out), along_m);
    }
    add(corner_m + depth_m_ * (inward_out + 2.0 * tangent_out), along_m);
    return;
  }
  // The two lines at press depth meet on the bisector. At a spike they meet far away; a concave
  // corner needs no more than twice the depth to press both walls, and the end of a slit is in the
  // way of who goes on.
  const Vec3 middle = inward_in + inward_out;
  const bool is_slit = turn_rad < -kTurnsBackRad;
  const Vec3 bisector = is_slit ? tangent_in : Vec3(middle.normalized());
  const double reach = is_slit ? depth_m_ : depth_m_ / std::max(0.5, bisector.dot(inward_in));
  add(corner_m + reach * bisector, along_m);
}

std::size_t ContourWay::leg_at(double along_m) const {
  const auto after = std::upper_bound(
      waypoints_.begin() + 1, waypoints_.end() - 1, along_m,
      [](double along, const Waypoint& waypoint) { return along < waypoint.along_m; });
  return static_cast<std::size_t>(after - waypoints_.begin()) - 1;
}

}  // namespace palpate
