#include "engine/contour_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr double kSharpCornerRad = std::numbers::pi / 4;

// The contour opened in the middle of its longest segment, which closes it again.
std::vector<Vec3> opened(const Polyline& contour) {
  std::vector<Vec3> points = contour.points_m;
  if (!contour.closed) return points;
  const std::size_t n = points.size();
  std::size_t longest = 0;
  const auto length = [&](std::size_t i) { return (points[(i + 1) % n] - points[i]).norm(); };
  for (std::size_t i = 1; i < n; ++i) {
    if (length(i) > length(longest)) longest = i;
  }
  const Vec3 middle = 0.5 * (points[longest] + points[(longest + 1) % n]);
  std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>((longest + 1) % n),
              points.end());
  points.insert(points.begin(), middle);
  points.push_back(middle);
  return points;
}

}  // namespace

ContourPlan::ContourPlan(const Polyline& contour, const Vec3& plane_normal_scene,
                         const ContourPlanSettings& settings)
    : settings_(settings), plane_normal_(plane_normal_scene), contour_(opened(contour)) {
  const auto tangent = [&](std::size_t i) { return (contour_[i + 1] - contour_[i]).normalized(); };
  const auto inward = [&](const Vec3& t) { return plane_normal_.cross(t); };
  contour_length_.push_back(0.0);
  for (std::size_t i = 0; i + 1 < contour_.size(); ++i) {
    contour_length_.push_back(contour_length_.back() + (contour_[i + 1] - contour_[i]).norm());
  }
  const Vec3 first = inward(tangent(0)) * settings_.press_depth_m;
  waypoints_.push_back(contour_.front() - 2 * first);
  waypoints_.push_back(contour_.front() + first);
  for (std::size_t i = 1; i + 1 < contour_.size(); ++i) {
    plan_corner(contour_[i], tangent(i - 1), tangent(i));
  }
  waypoints_.push_back(contour_.back() +
                       inward(tangent(contour_.size() - 2)) * settings_.press_depth_m);
  finish_plan();
}

void ContourPlan::plan_corner(const Vec3& corner, const Vec3& tangent_in, const Vec3& tangent_out) {
  const double depth = settings_.press_depth_m;
  const Vec3 inward_in = plane_normal_.cross(tangent_in);
  const Vec3 inward_out = plane_normal_.cross(tangent_out);
  const double turn =
      std::atan2(tangent_in.cross(tangent_out).dot(plane_normal_), tangent_in.dot(tangent_out));
  if (turn >= kSharpCornerRad) {
    waypoints_.push_back(corner + depth * (inward_in + tangent_in));
    waypoints_.push_back(corner + depth * (inward_out + 2.0 * tangent_out));
    return;
  }
  // The two lines at press depth meet on the bisector. At a spike they meet far away; a concave
  // corner needs no more than twice the depth to press both walls.
  const Vec3 bisector = (inward_in + inward_out).normalized();
  const double reach = depth / std::max(0.5, bisector.dot(inward_in));
  waypoints_.push_back(corner + reach * bisector);
}

void ContourPlan::finish_plan() {
  double around_m = 0.0;
  for (std::size_t i = 2; i < waypoints_.size(); ++i) {
    around_m += (waypoints_[i] - waypoints_[i - 1]).norm();
  }
  arrival_s_ = {0.0, settings_.approach_s};
  for (std::size_t i = 2; i < waypoints_.size(); ++i) {
    const double leg_m = (waypoints_[i] - waypoints_[i - 1]).norm();
    arrival_s_.push_back(arrival_s_.back() + settings_.turn_s * leg_m / around_m);
  }
}

HandTarget ContourPlan::target(double time_s, const ScenePose& T_device_scene,
                               const TickRecord& last) noexcept {
  track(last);
  while (leg_ + 2 < waypoints_.size() && time_s >= arrival_s_[leg_ + 1]) ++leg_;
  const double leg_s = arrival_s_[leg_ + 1] - arrival_s_[leg_];
  const double along = leg_s > 0.0 ? (time_s - arrival_s_[leg_]) / leg_s : 1.0;
  const Vec3 leg = waypoints_[leg_ + 1] - waypoints_[leg_];
  const Vec3 planned = waypoints_[leg_] + std::min(1.0, along) * leg;
  correct_lag(planned - last.goal_m, leg.normalized(), time_s);
  HandTarget target;
  target.position_m = T_device_scene.point(planned + correction_m_);
  if (along < 1.0) target.velocity_m_per_s = T_device_scene.direction(leg / leg_s);
  return target;
}

// Integrates the part of the lag along the leg; what an earlier leg left over counts as far as it
// points along this one.
void ContourPlan::correct_lag(const Vec3& lag_m, const Vec3& direction, double time_s) {
  const double dt_s = time_s - corrected_at_s_;
  corrected_at_s_ = time_s;
  const double along_m =
      correction_m_.dot(direction) + settings_.visual_gain_per_s * dt_s * lag_m.dot(direction);
  correction_m_ =
      std::clamp(along_m, -settings_.max_correction_m, settings_.max_correction_m) * direction;
}

// Moves on to the next wall while the proxy is nearer to it than to the present one, so that a
// stalled proxy makes no progress and a passage near another part of the contour does not count.
void ContourPlan::track(const TickRecord& last) {
  if (!last.contact) return;
  const auto nearest_on = [&](std::size_t wall, double& along_m) {
    const Vec3 d = contour_[wall + 1] - contour_[wall];
    const double t = std::clamp((last.proxy_m - contour_[wall]).dot(d) / d.squaredNorm(), 0.0, 1.0);
    along_m = contour_length_[wall] + t * d.norm();
    return (last.proxy_m - contour_[wall] - t * d).norm();
  };
  double along_m = 0.0;
  double distance = nearest_on(wall_, along_m);
  while (wall_ + 2 < contour_.size()) {
    double next_along_m = 0.0;
    const double next_distance = nearest_on(wall_ + 1, next_along_m);
    if (next_distance >= distance) break;
    ++wall_;
    distance = next_distance;
    along_m = next_along_m;
  }
  farthest_m_ = std::max(farthest_m_, along_m);
}

double ContourPlan::turn_fraction() const {
  return farthest_m_ / contour_length_.back();
}

}  // namespace palpate
