#include "engine/contour_plan.h"

#include <algorithm>
#include <cmath>

#include "geometry/collinear_runs.h"

namespace palpate {
namespace {

// In press depths: what the hand does not follow; how far it rests in front; how far the proxy may
// be behind; how near to a corner it is there; how far from the contour it is not on it any more;
// how far along the contour it may get in one tick; where an open contour is touched first; what
// the proxy gets on by at least if it gets on.
constexpr double kSmall = 0.25;
constexpr double kInFront = 2.0;
constexpr double kMostLead = 5.0;
constexpr double kAtCorner = 0.5;
constexpr double kOffContour = 0.5;
constexpr double kSearched = 4.0;
constexpr double kFromEnd = 1.0;
constexpr double kGetsOn = 0.25;

// A wall is touched from behind if the cosine of the felt normal and the one into it is more.
constexpr double kFromBehind = 0.5;

// A hand that has waited makes up for it with so many times its usual speed at most.
constexpr double kMostHaste = 3.0;

// Of a contour, how much farther on a hand touches it again at most.
constexpr double kFarthestOn = 0.125;

std::vector<double> lengths_of(const std::vector<Vec3>& points_m) {
  std::vector<double> lengths_m{0.0};
  for (std::size_t i = 0; i + 1 < points_m.size(); ++i) {
    lengths_m.push_back(lengths_m.back() + (points_m[i + 1] - points_m[i]).norm());
  }
  return lengths_m;
}

}  // namespace

ContourPlan::ContourPlan(const Polyline& contour, const std::vector<Polyline>& curves,
                         const Vec3& plane_normal_scene, const ContourPlanSettings& settings)
    : settings_(settings),
      plane_normal_(plane_normal_scene),
      is_closed_(contour.closed),
      room_m_(kInFront * settings.press_depth_m) {
  const double depth = settings_.press_depth_m;
  whole_contour_m_ = open_contour(contour, curves, plane_normal_, room_m_);
  contour_m_ = without_collinear_points(whole_contour_m_, false, plane_normal_, kSmall * depth);
  if (contour_m_.size() < 2) contour_m_ = whole_contour_m_;
  contour_length_m_ = lengths_of(contour_m_);
  ways_.emplace_back(contour_m_, whole_contour_m_, plane_normal_, depth, 1.0);
  if (!is_closed_) ways_.emplace_back(contour_m_, whole_contour_m_, plane_normal_, depth, -1.0);
  // Where an open contour ends a hand slips off.
  const double first_m =
      is_closed_ ? 0.0 : std::min(kFromEnd * depth, 0.25 * contour_length_m_.back());
  const Vec3 first = place(first_m);
  const Vec3 into = is_closed_ ? Vec3(plane_normal_.cross(whole_contour_m_[1] - first).normalized())
                               : inward(first_m);
  const Vec3 touched = first + depth * into;
  start_m_ = first - room_m_ * into;
  detour_.from_m = start_m_;
  detour_.add(touched);
  detour_.speed_m_per_s = (touched - start_m_).norm() / settings_.approach_s;
  detour_.ends_along_m = proxy_along_m_ = first_m;
  lift_step_m_ = depth;
}

std::size_t ContourPlan::wall_at(double along_m) const {
  const auto after =
      std::upper_bound(contour_length_m_.begin() + 1, contour_length_m_.end() - 1, along_m);
  return static_cast<std::size_t>(after - contour_length_m_.begin()) - 1;
}

Vec3 ContourPlan::place(double along_m) const {
  const std::size_t wall = wall_at(along_m);
  return contour_m_[wall] + (along_m - contour_length_m_[wall]) *
                                (contour_m_[wall + 1] - contour_m_[wall]).normalized();
}

Vec3 ContourPlan::inward(double along_m) const {
  const std::size_t wall = wall_at(along_m);
  const Vec3 left = plane_normal_.cross((contour_m_[wall + 1] - contour_m_[wall]).normalized());
  return is_on_right_ ? Vec3(-left) : left;
}

HandTarget ContourPlan::target(double time_s, const ScenePose& T_device_scene,
                               const TickRecord& last) noexcept {
  const double dt_s = time_s - last_time_s_;
  last_time_s_ = time_s;
  if (detour_.is_done()) {
    track(last);
    if (is_out_of_patience(last.contact, dt_s)) lift(last);
  }
  const Aim aim = detour_.is_done() ? follow(time_s, dt_s) : detour(last, dt_s);
  correct_lag(aim.p_m - last.goal_m, aim.direction, dt_s);
  HandTarget target;
  target.position_m = T_device_scene.point(aim.p_m + correction_m_);
  target.velocity_m_per_s = T_device_scene.direction(aim.speed_m_per_s * aim.direction);
  return target;
}

// Whether the proxy is not too far behind for the hand to go on.
bool ContourPlan::may_advance() const {
  const ContourWay::Waypoint& from = way().waypoints()[leg_];
  const ContourWay::Waypoint& to = way().waypoints()[leg_ + 1];
  const double depth = settings_.press_depth_m;
  if (from.is_turn && proxy_along_m_ < from.along_m - kAtCorner * depth) return false;
  const double leg_m = to.way_m - from.way_m;
  const double part = leg_m > 0.0 ? (way_m_ - from.way_m) / leg_m : 1.0;
  const double along_m = from.along_m + part * (to.along_m - from.along_m);
  return along_m - proxy_along_m_ <= kMostLead * depth;
}

// At such a speed that it is round in time.
ContourPlan::Aim ContourPlan::follow(double time_s, double dt_s) {
  const double end_m = way().length_m();
  double speed_m_per_s = 0.0;
  if (way_m_ < end_m && may_advance()) {
    const double usual_m_per_s = end_m / settings_.turn_s;
    const double left_s = settings_.approach_s + settings_.turn_s - time_s;
    speed_m_per_s = kMostHaste * usual_m_per_s;
    if (left_s > 0.0) speed_m_per_s = std::min(speed_m_per_s, (end_m - way_m_) / left_s);
    advance(speed_m_per_s * dt_s);
  }
  const ContourWay::Waypoint& from = way().waypoints()[leg_];
  const Vec3 direction = (way().waypoints()[leg_ + 1].p_m - from.p_m).normalized();
  return {from.p_m + (way_m_ - from.way_m) * direction, direction, speed_m_per_s};
}

void ContourPlan::advance(double way_m) {
  const auto& waypoints = way().waypoints();
  while (way_m > 0.0) {
    const double to_m = std::min(way_m, waypoints[leg_ + 1].way_m - way_m_);
    way_m_ += to_m;
    way_m -= to_m;
    if (way_m_ < waypoints[leg_ + 1].way_m || leg_ + 2 >= waypoints.size()) return;
    ++leg_;
    way_m_ = waypoints[leg_].way_m;
    if (!may_advance()) return;
  }
}

ContourPlan::Aim ContourPlan::detour(const TickRecord& last, double dt_s) {
  Detour& d = detour_;
  d.way_m += d.speed_m_per_s * dt_s;
  const Vec3 to = d.points_m[d.next];
  const Vec3 leg = to - d.from_m;
  const Aim aim{d.from_m + std::min(d.way_m, leg.norm()) * leg.normalized(), leg.normalized(),
                d.speed_m_per_s};
  if (d.way_m >= leg.norm()) {
    d.from_m = to;
    d.way_m = 0.0;
    if (++d.next == d.count) end_detour(last);
  }
  return aim;
}

// Goes on along the contour from where it has been touched: farther back, where something was in
// the way.
void ContourPlan::end_detour(const TickRecord& last) {
  proxy_along_m_ = detour_.ends_along_m;
  wall_ = wall_at(proxy_along_m_);
  if (last.contact && !track(last)) find(last, 0.0, detour_.ends_along_m);
  waited_at_m_ = proxy_along_m_;
  waited_s_ = 0.0;
  leg_ = way().leg_at(proxy_along_m_);
  const ContourWay::Waypoint& from = way().waypoints()[leg_];
  const ContourWay::Waypoint& to = way().waypoints()[leg_ + 1];
  const double walls_m = to.along_m - from.along_m;
  const double part =
      walls_m > 0.0 ? std::clamp((proxy_along_m_ - from.along_m) / walls_m, 0.0, 1.0) : 0.0;
  way_m_ = from.way_m + part * (to.way_m - from.way_m);
}

// Whether the hand waits and the proxy does not get on.
bool ContourPlan::is_out_of_patience(bool is_in_contact, double dt_s) {
  const double depth = settings_.press_depth_m;
  const bool gets_on = std::abs(proxy_along_m_ - waited_at_m_) > kGetsOn * depth;
  if (gets_on) {
    if (proxy_along_m_ > waited_at_m_) lift_step_m_ = depth;
    waited_at_m_ = proxy_along_m_;
  }
  const bool is_at_end = way_m_ >= way().length_m();
  const bool is_there = proxy_along_m_ >= contour_length_m_.back() - depth;
  const bool is_well = is_in_contact && (gets_on || (is_at_end ? is_there : may_advance()));
  waited_s_ = is_well ? 0.0 : waited_s_ + dt_s;
  return waited_s_ > settings_.patience_s;
}

// Away from what it touches, to the front of the contour a little farther on, and down again.
void ContourPlan::lift(const TickRecord& last) {
  const double depth = settings_.press_depth_m;
  const double whole_m = contour_length_m_.back();
  const double along_m = std::min(whole_m, proxy_along_m_ + lift_step_m_);
  lift_step_m_ = std::min(2.0 * lift_step_m_, kFarthestOn * whole_m);
  if (!is_closed_) {
    is_on_right_ = false;
    is_on_right_ = (last.proxy_m - place(along_m)).dot(inward(along_m)) > 0.0;
  }
  detour_ = {};
  detour_.from_m = last.goal_m;
  detour_.speed_m_per_s = settings_.lift_speed_m_per_s;
  detour_.ends_along_m = along_m;
  if (last.contact) detour_.add(last.proxy_m + room_m_ * last.normal_scene);
  detour_.add(place(along_m) - room_m_ * inward(along_m));
  detour_.add(place(along_m) + depth * inward(along_m));
}

// Integrates the part of the lag along the leg; what an earlier leg left over counts as far as it
// points along this one.
void ContourPlan::correct_lag(const Vec3& lag_m, const Vec3& direction, double dt_s) {
  const double along_m =
      correction_m_.dot(direction) + settings_.visual_gain_per_s * dt_s * lag_m.dot(direction);
  correction_m_ =
      std::clamp(along_m, -settings_.max_correction_m, settings_.max_correction_m) * direction;
}

// Near where the proxy was last: a passage near another part of the contour does not count.
bool ContourPlan::track(const TickRecord& last) {
  const double searched_m = kSearched * settings_.press_depth_m;
  return find(last, proxy_along_m_ - searched_m, proxy_along_m_ + searched_m);
}

// Finds the proxy on a part of the contour; false, and where it was last, if it is off it.
bool ContourPlan::find(const TickRecord& last, double first_m, double last_m) {
  const double off_m = kOffContour * settings_.press_depth_m;
  double nearest_m = off_m;
  double found_m = proxy_along_m_;
  std::size_t found_wall = wall_;
  const auto look_at = [&](std::size_t wall) {
    const double from_m = contour_length_m_[wall];
    const double length_m = contour_length_m_[wall + 1] - from_m;
    if (length_m == 0.0) return;
    const Vec3 direction = (contour_m_[wall + 1] - contour_m_[wall]) / length_m;
    // The back of a thin part is near, too.
    const Vec3 left = plane_normal_.cross(direction);
    if (last.contact && last.normal_scene.dot(is_on_right_ ? -left : left) > kFromBehind) return;
    const double at_m = std::clamp((last.proxy_m - contour_m_[wall]).dot(direction),
                                   std::clamp(first_m - from_m, 0.0, length_m),
                                   std::clamp(last_m - from_m, 0.0, length_m));
    const double distance_m = (last.proxy_m - contour_m_[wall] - at_m * direction).norm();
    if (distance_m >= nearest_m) return;
    nearest_m = distance_m;
    found_m = from_m + at_m;
    found_wall = wall;
  };
  for (std::size_t w = wall_; w + 1 < contour_m_.size() && contour_length_m_[w] <= last_m; ++w) {
    look_at(w);
  }
  for (std::size_t w = wall_; w-- > 0 && contour_length_m_[w + 1] >= first_m;) look_at(w);
  wall_ = found_wall;
  proxy_along_m_ = found_m;
  return nearest_m < off_m;
}

}  // namespace palpate
