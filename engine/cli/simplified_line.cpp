#include "engine/cli/simplified_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// Every dropped vertex lies within `step` of the kept vertex before it, and so do the segments
// between dropped vertices. The segment from the last of them to the next kept vertex is within
// `step` of the segment between the two kept vertices.
std::vector<PicturePoint> thinned(const std::vector<PicturePoint>& line, double step) {
  std::vector<PicturePoint> kept;
  for (const PicturePoint& p : line) {
    if (kept.empty() || (p - kept.back()).norm() > step) kept.push_back(p);
  }
  if (!line.empty() && kept.back() != line.back()) kept.push_back(line.back());
  return kept;
}

// The directions in which a ray from an anchor passes all later points within a distance.
class Sleeve {
 public:
  explicit Sleeve(double width) : width_(width) {}

  void start(const PicturePoint& anchor) {
    anchor_ = anchor;
    farthest_ = 0.0;
    is_open_ = true;
  }

  // Whether the segment from the anchor to p passes all points since the anchor within the width:
  // the ray does, and none of them is farther away than p. If so, p becomes one of the points.
  bool extend(const PicturePoint& p) {
    const PicturePoint away = p - anchor_;
    const double distance = away.norm();
    if (distance < farthest_) return false;
    farthest_ = distance;
    if (distance <= width_) return true;
    const double angle = std::atan2(away.y(), away.x());
    const double half = std::asin(width_ / distance);
    if (is_open_) {
      middle_ = angle;
      low_ = -half;
      high_ = half;
      is_open_ = false;
      return true;
    }
    const double turn = std::remainder(angle - middle_, 2.0 * std::numbers::pi);
    if (turn < low_ || turn > high_) return false;
    low_ = std::max(low_, turn - half);
    high_ = std::min(high_, turn + half);
    return true;
  }

 private:
  double width_;
  PicturePoint anchor_ = PicturePoint::Zero();
  double farthest_ = 0.0;
  bool is_open_ = true;                           // every direction is in it
  double middle_ = 0.0, low_ = 0.0, high_ = 0.0;  // rad; low and high from the middle
};

}  // namespace

std::vector<PicturePoint> simplified_line(const std::vector<PicturePoint>& line, double tolerance) {
  // The two steps add up to the tolerance. Without the first one, noise of a path that stands still
  // would end a sleeve at every point.
  const std::vector<PicturePoint> points = thinned(line, 0.4 * tolerance);
  if (points.size() < 3) return points;
  std::vector<PicturePoint> kept{points.front()};
  Sleeve sleeve(0.6 * tolerance);
  sleeve.start(points.front());
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (sleeve.extend(points[i])) continue;
    kept.push_back(points[i - 1]);
    sleeve.start(points[i - 1]);
    sleeve.extend(points[i]);
  }
  kept.push_back(points.back());
  return kept;
}

}  // namespace palpate
