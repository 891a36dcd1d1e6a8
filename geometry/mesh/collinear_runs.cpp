#include "geometry/mesh/collinear_runs.h"

#include <algorithm>

namespace palpate {
namespace {

// The cone of directions from an apex in which a line passes within the tolerance of all added
// points. Requires points in one half-plane, which holds for a run that does not turn back.
class DirectionCone {
 public:
  DirectionCone(const Vec3& plane_normal, double tolerance_m)
      : normal_(plane_normal), tolerance_m_(tolerance_m) {}

  // offset_m: from the apex, longer than the tolerance.
  void start(const Vec3& offset_m) {
    const Vec3 aside = sideways(offset_m);
    right_ = offset_m - aside;
    left_ = offset_m + aside;
  }
  void narrow(const Vec3& offset_m) {
    if (offset_m.norm() <= tolerance_m_) return;  // within tolerance of every line through the apex
    const Vec3 aside = sideways(offset_m);
    if (turn(right_, offset_m - aside) > 0.0) right_ = offset_m - aside;
    if (turn(left_, offset_m + aside) < 0.0) left_ = offset_m + aside;
  }
  bool holds(const Vec3& offset_m) const {
    return turn(right_, offset_m) >= 0.0 && turn(left_, offset_m) <= 0.0;
  }

 private:
  Vec3 sideways(const Vec3& v) const { return normal_.cross(v) * (tolerance_m_ / v.norm()); }
  double turn(const Vec3& from, const Vec3& to) const { return normal_.dot(from.cross(to)); }

  Vec3 normal_;
  double tolerance_m_;
  Vec3 right_ = Vec3::Zero();
  Vec3 left_ = Vec3::Zero();
};

// Rotates a closed curve to start at its point farthest from the first one: a corner of its convex
// hull, which no segment could replace.
void start_at_corner(std::vector<Vec3>& points_m) {
  const Vec3 reference_m = points_m.front();
  const auto corner =
      std::max_element(points_m.begin(), points_m.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - reference_m).squaredNorm() < (b - reference_m).squaredNorm();
      });
  std::rotate(points_m.begin(), corner, points_m.end());
}

}  // namespace

std::vector<Vec3> without_collinear_points(std::vector<Vec3> points_m, bool closed,
                                           const Vec3& plane_normal, double tolerance_m) {
  if (points_m.empty()) return points_m;
  if (closed) {
    start_at_corner(points_m);
    points_m.push_back(points_m.front());
  }
  std::vector<Vec3> kept = {points_m.front()};
  DirectionCone cone(plane_normal, tolerance_m);
  bool has_end = false;  // the segment from kept.back() to `end` represents the points so far
  Vec3 end = points_m.front();
  for (const Vec3& point : points_m) {
    if ((point - end).norm() <= tolerance_m) {
      if (has_end) cone.narrow(point - kept.back());
      continue;
    }
    const Vec3 offset_m = point - kept.back();
    const bool goes_on =
        has_end && cone.holds(offset_m) && (point - end).dot(end - kept.back()) > 0.0;
    if (goes_on) {
      cone.narrow(offset_m);
    } else {
      if (has_end) kept.push_back(end);
      cone.start(point - kept.back());
    }
    end = point;
    has_end = true;
  }
  if (has_end && !closed) kept.push_back(end);
  return kept;
}

}  // namespace palpate
