#include "engine/simulation/path_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// In press depths: the largest distance of the proxy behind the hand; the distance at which the
// proxy counts as at a corner; the distance at which the proxy has left the path; the search range
// along the path in one tick; the distance from the end at which an open contour is touched first;
// the least advance of the proxy that counts as progress.
constexpr double kMostLead = 5.0;
constexpr double kAtCorner = 0.5;
constexpr double kOffPath = 0.5;
constexpr double kSearched = 4.0;
constexpr double kFromEnd = 1.0;
constexpr double kGetsOn = 0.25;

// A wall is touched from behind if the cosine between the contact normal and the inward direction
// of the wall exceeds this.
constexpr double kFromBehind = 0.5;

// The largest speed of a hand that has waited, as a multiple of its usual speed.
constexpr double kMostHaste = 3.0;

// The largest distance from a lift to the next touch, as a share of the path.
constexpr double kFarthestOn = 0.125;

// A hand that makes no progress for longer than kHeldUp_s, or is pushed aside, presses less. The
// change per second and its maximum are shares of the press depth.
constexpr double kHeldUp_s = 0.2;
constexpr double kEase_per_s = 2.0;
constexpr double kMostEase = 0.75;

// A correction is undone this many times faster than it is built up.
constexpr double kUnwinds = 3.0;

// Below this sine the hand moves straight into a wall or away from it; no wall then supports it
// sideways.
constexpr double kAlongNoWall = 1e-3;

}  // namespace

PathPlan::PathPlan(HandPath path, const PathFacts& facts, const PathPlanSettings& settings)
    : settings_(settings), facts_(facts), length_m_(path.lengths_m()) {
  const double depth = settings_.press_depth_m;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.points[i].is_turn) turns_m_.push_back(length_m_[i]);
  }
  if (facts.sides != PathSides::kFront) paths_.push_back(other_side(path));
  paths_.insert(paths_.begin(), std::move(path));
  for (const HandPath& side : paths_) tracks_.emplace_back(side, depth);
  const double first_m =
      facts.slips_off_at_ends ? std::min(kFromEnd * depth, 0.25 * length_m_.back()) : 0.0;
  const Vec3 first = place_m(first_m);
  const Vec3 touched = first + depth * inward(first_m);
  start_m_ = first - facts.room_m * inward(first_m);
  detour_.from_m = start_m_;
  detour_.add(touched);
  detour_.speed_m_per_s = (touched - start_m_).norm() / settings_.approach_s;
  detour_.ends_along_m = proxy_along_m_ = first_m;
  lift_step_m_ = depth;
}

// From the contact point of a sphere to its centre.
Vec3 PathPlan::to_centre_m(const TickRecord& last) const {
  const bool has_normal = last.contact && !vec3(last.normal_scene).isZero(0.0);
  return facts_.proxy_radius_m *
         (has_normal ? vec3(last.normal_scene) : Vec3(-inward(proxy_along_m_)));
}

// The hand follows the path with the sphere's contact point instead of its centre.
HandTarget PathPlan::target(double time_s, const ScenePose& T_device_scene,
                            const TickRecord& last) noexcept {
  const Vec3 to_centre = to_centre_m(last);
  TickRecord touching = last;
  put(vec3(last.proxy_scene_m) - to_centre, touching.proxy_scene_m);
  put(vec3(last.goal_scene_m) - to_centre, touching.goal_scene_m);
  HandTarget target = touching_target(time_s, T_device_scene, touching);
  target.position_m += T_device_scene.direction(to_centre);
  return target;
}

HandTarget PathPlan::touching_target(double time_s, const ScenePose& T_device_scene,
                                     const TickRecord& last) noexcept {
  const double dt_s = time_s - last_time_s_;
  last_time_s_ = time_s;
  if (detour_.is_done()) {
    if (!locate_proxy(last) && is_round_edge(last)) proxy_along_m_ = hand_along_m();
    if (is_out_of_patience(last.contact, dt_s)) lift(last);
  }
  const Aim aim = detour_.is_done() ? follow(time_s, dt_s) : detour(last, dt_s);
  const Vec3 correction_m = correct_lag(aim, last, dt_s);
  HandTarget target;
  target.position_m = T_device_scene.point(aim.p_m + correction_m);
  target.velocity_m_per_s = T_device_scene.direction(aim.speed_m_per_s * aim.direction);
  return target;
}

// Whether the proxy is near enough for the hand to advance.
bool PathPlan::may_advance() const {
  const TargetTrack::Waypoint& from = track().waypoints()[leg_];
  const double depth = settings_.press_depth_m;
  if (from.is_turn && proxy_along_m_ < from.along_m - kAtCorner * depth) return false;
  return hand_along_m() - proxy_along_m_ <= kMostLead * depth;
}

// Whether the hand waits beyond an edge and the proxy has arrived there without contact.
bool PathPlan::is_round_edge(const TickRecord& last) const {
  const TargetTrack::Waypoint& at = track().waypoints()[leg_];
  return at.is_turn && !last.contact &&
         (vec3(last.proxy_scene_m) - at.p_m).norm() <= kAtCorner * settings_.press_depth_m;
}

// Advances along the path at the speed that reaches the end in time.
PathPlan::Aim PathPlan::follow(double time_s, double dt_s) {
  const double end_m = track().length_m();
  double speed_m_per_s = 0.0;
  if (travelled_m_ < end_m && may_advance()) {
    const double usual_m_per_s = end_m / settings_.follow_s;
    const double left_s = settings_.approach_s + settings_.follow_s - time_s;
    speed_m_per_s = kMostHaste * usual_m_per_s;
    if (left_s > 0.0) speed_m_per_s = std::min(speed_m_per_s, (end_m - travelled_m_) / left_s);
    advance(speed_m_per_s * dt_s);
  }
  const TargetTrack::Waypoint& from = track().waypoints()[leg_];
  const Vec3 direction = (track().waypoints()[leg_ + 1].p_m - from.p_m).normalized();
  const Vec3 lightened_m = -ease(dt_s) * settings_.press_depth_m * from.inward.normalized();
  return {from.p_m + (travelled_m_ - from.track_m) * direction + lightened_m, direction,
          from.inward, speed_m_per_s};
}

// The share by which the hand reduces its press depth. It grows while the hand makes no progress,
// for example because of friction, and with the sideways push.
double PathPlan::ease(double dt_s) {
  const double pushed_m = correction_m_.norm() - settings_.press_depth_m;
  const double hardest_m = settings_.max_correction_m - settings_.press_depth_m;
  const double wanted =
      waited_s_ > kHeldUp_s
          ? kMostEase
          : std::max(settings_.least_ease, kMostEase * std::clamp(pushed_m / hardest_m, 0.0, 1.0));
  ease_ += std::clamp(wanted - ease_, -kEase_per_s * dt_s, kEase_per_s * dt_s);
  return ease_;
}

void PathPlan::advance(double step_m) {
  const auto& waypoints = track().waypoints();
  while (step_m > 0.0) {
    const double to_m = std::min(step_m, waypoints[leg_ + 1].track_m - travelled_m_);
    travelled_m_ += to_m;
    step_m -= to_m;
    if (travelled_m_ < waypoints[leg_ + 1].track_m || leg_ + 2 >= waypoints.size()) return;
    ++leg_;
    travelled_m_ = waypoints[leg_].track_m;
    if (!may_advance()) return;
  }
}

PathPlan::Aim PathPlan::detour(const TickRecord& last, double dt_s) {
  Detour& d = detour_;
  d.travelled_m += d.speed_m_per_s * dt_s;
  const Vec3 to = d.points_m[d.next];
  const Vec3 leg = to - d.from_m;
  const Aim aim{d.from_m + std::min(d.travelled_m, leg.norm()) * leg.normalized(), leg.normalized(),
                Vec3::Zero(), d.speed_m_per_s};
  if (d.travelled_m >= leg.norm()) {
    d.from_m = to;
    d.travelled_m = 0.0;
    if (++d.next == d.count) end_detour(last);
  }
  return aim;
}

// Continues along the path from the point touched, which is farther back if an obstacle was in the
// way.
void PathPlan::end_detour(const TickRecord& last) {
  go_on_from(detour_.ends_along_m);
  if (last.contact && !locate_proxy(last)) find(last, detour_.begins_along_m, detour_.ends_along_m);
  go_on_from(proxy_along_m_);
  waited_at_m_ = proxy_along_m_;
  waited_s_ = 0.0;
}

void PathPlan::go_on_from(double along_m) {
  proxy_along_m_ = along_m;
  wall_ = leg_at(length_m_, along_m);
  leg_ = track().leg_at(along_m);
  travelled_m_ = track().track_m(leg_, along_m);
}

// Whether the hand has waited for too long without progress of the proxy.
bool PathPlan::is_out_of_patience(bool is_in_contact, double dt_s) {
  const double depth = settings_.press_depth_m;
  const bool gets_on = proxy_along_m_ - waited_at_m_ > kGetsOn * depth;
  if (gets_on) {
    lift_step_m_ = depth;
    waited_at_m_ = proxy_along_m_;
  }
  const bool is_at_end = travelled_m_ >= track().length_m();
  const bool is_there = proxy_along_m_ >= length_m_.back() - depth;
  const bool is_well = is_in_contact && (gets_on || (is_at_end ? is_there : may_advance()));
  waited_s_ = is_well ? 0.0 : waited_s_ + dt_s;
  return waited_s_ > settings_.patience_s;
}

// Whether the proxy is without contact directly behind the wall: no solid is there, and the hand
// has passed the wall's boundary.
bool PathPlan::is_behind_wall(const TickRecord& last) const {
  if (last.contact) return false;
  const Vec3 offset_m = vec3(last.proxy_scene_m) - place_m(proxy_along_m_);
  const double behind_m = offset_m.dot(inward(proxy_along_m_));
  const double aside_m = (offset_m - behind_m * inward(proxy_along_m_)).norm();
  return behind_m > 0.0 && behind_m < kRestsInFront * settings_.press_depth_m &&
         aside_m < kOffPath * settings_.press_depth_m;
}

// Moves the hand away from the surface, to a point in front of the path a little farther on, and
// down again.
void PathPlan::lift(const TickRecord& last) {
  const double depth = settings_.press_depth_m;
  const double whole_m = length_m_.back();
  const double along_m = std::min(whole_m, proxy_along_m_ + lift_step_m_);
  lift_step_m_ = std::min(2.0 * lift_step_m_, kFarthestOn * whole_m);
  if (facts_.sides == PathSides::kEither) {
    is_behind_ = false;
    is_behind_ = (vec3(last.proxy_scene_m) - place_m(along_m)).dot(inward(along_m)) > 0.0;
  } else if (facts_.sides == PathSides::kWhereFree && is_behind_wall(last)) {
    is_behind_ = !is_behind_;
  }
  detour_ = {};
  detour_.from_m = vec3(last.goal_scene_m);
  detour_.speed_m_per_s = settings_.lift_speed_m_per_s;
  if (facts_.may_cross_itself) {
    detour_.begins_along_m = std::max(0.0, proxy_along_m_ - kSearched * depth);
  }
  detour_.ends_along_m = along_m;
  if (last.contact) detour_.add(vec3(last.proxy_scene_m) + facts_.room_m * vec3(last.normal_scene));
  detour_.add(place_m(along_m) - facts_.room_m * inward(along_m));
  detour_.add(place_m(along_m) + depth * inward(along_m));
}

// Integrates the lag in the directions in which no wall resists the hand: along its motion, and
// perpendicular to it along the wall. The correction from an earlier leg is projected onto these
// directions. Towards the wall the hand presses more as long as it is not in contact, because a
// force may pull it away.
Vec3 PathPlan::correct_lag(const Aim& aim, const TickRecord& last, double dt_s) {
  const Vec3 lag_m = aim.p_m - vec3(last.goal_scene_m);
  // The correction is undone faster once the obstacle has gone.
  const double gain = lag_m.dot(correction_m_) < 0.0 ? kUnwinds : 1.0;
  Vec3 correction_m = correction_m_ + gain * settings_.visual_gain_per_s * dt_s * lag_m;
  Vec3 held = aim.inward - aim.inward.dot(aim.direction) * aim.direction;
  const bool is_held = held.norm() > kAlongNoWall;
  if (is_held) held.normalize();
  correction_m_ = is_held ? Vec3(correction_m - correction_m.dot(held) * held)
                          : Vec3(correction_m.dot(aim.direction) * aim.direction);
  const double length_m = correction_m_.norm();
  if (length_m > settings_.max_correction_m) {
    correction_m_ *= settings_.max_correction_m / length_m;
  }
  if (!is_held) return correction_m_;
  const double short_m = lag_m.dot(held);
  if (!last.contact || short_m < 0.0) {
    press_more_m_ = std::clamp(press_more_m_ + settings_.visual_gain_per_s * dt_s * short_m, 0.0,
                               settings_.max_correction_m);
  }
  return correction_m_ + press_more_m_ * held;
}

// Searches for the proxy near its last position and up to the hand. Distant parts of the path that
// happen to be near are not searched, nor are parts beyond the hand's next turn or before its last
// turn.
bool PathPlan::locate_proxy(const TickRecord& last) {
  const double searched_m = kSearched * settings_.press_depth_m;
  const double hand_m = hand_along_m();
  const auto next_turn = std::lower_bound(turns_m_.begin(), turns_m_.end(), hand_m);
  double first_m = proxy_along_m_ - searched_m;
  double last_m = std::max(proxy_along_m_ + searched_m, hand_m);
  if (next_turn != turns_m_.begin()) first_m = std::max(first_m, *(next_turn - 1));
  if (next_turn != turns_m_.end()) last_m = std::min(last_m, *next_turn);
  return find(last, std::min(first_m, last_m), last_m);
}

// Finds the proxy on a part of the path. If the proxy is off the path, returns false and keeps its
// last position.
bool PathPlan::find(const TickRecord& last, double first_m, double last_m) {
  const double off_m = kOffPath * settings_.press_depth_m;
  const auto& points = path().points;
  double nearest_m = off_m;
  double found_m = proxy_along_m_;
  std::size_t found_wall = wall_;
  const auto test_wall = [&](std::size_t wall) {
    const double from_m = length_m_[wall];
    const double length_m = length_m_[wall + 1] - from_m;
    if (length_m == 0.0) return;
    const Vec3 direction = (points[wall + 1].p_m - points[wall].p_m) / length_m;
    // The back of a thin part is also near, but does not count.
    if (last.contact && vec3(last.normal_scene).dot(points[wall].inward) > kFromBehind) return;
    const double at_m = std::clamp((vec3(last.proxy_scene_m) - points[wall].p_m).dot(direction),
                                   std::clamp(first_m - from_m, 0.0, length_m),
                                   std::clamp(last_m - from_m, 0.0, length_m));
    const double distance_m =
        (vec3(last.proxy_scene_m) - points[wall].p_m - at_m * direction).norm();
    if (distance_m >= nearest_m) return;
    nearest_m = distance_m;
    found_m = from_m + at_m;
    found_wall = wall;
  };
  for (std::size_t w = wall_; w + 1 < points.size() && length_m_[w] <= last_m; ++w) {
    test_wall(w);
  }
  for (std::size_t w = wall_; w-- > 0 && length_m_[w + 1] >= first_m;) test_wall(w);
  wall_ = found_wall;
  proxy_along_m_ = found_m;
  return nearest_m < off_m;
}

}  // namespace palpate
