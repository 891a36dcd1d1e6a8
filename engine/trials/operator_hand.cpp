#include "engine/trials/operator_hand.h"

#include <algorithm>
#include <cmath>

#include "engine/simulation/path_plan.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// The pace: its largest share of v0 before a corner, and the distance from which a corner slows the
// hand.
constexpr double kPaceAtCorner = 0.3;
constexpr double kSeesCorner_m = 10e-3;

// How far the target may be ahead of the seen place; in a corner by this many press depths more.
constexpr double kMostLead_m = 15e-3;
constexpr double kMoreLeadInCorner = 3.0;

constexpr double kMostCorrection_m = 20e-3;

// Recovery: the time without a good contact, also in a corner; the place that the hand goes to, and
// how far outside the contour it goes first, in press depths; its speed, in v0.
constexpr double kPatience_s = 0.5;
constexpr double kPatienceInCorner_s = 1.5;
constexpr double kGoesOn_m = 10e-3;
constexpr double kOutside = 1.5;
constexpr double kHaste = 2.0;
// The distance between the points that the hand visits on its way back outside the contour.
constexpr double kStride_m = 5e-3;

// With View::kStill: how far the hand may go beyond the farthest place of the path.
constexpr double kArm_m = 1.0;

// In press depths: the hand rests at the start this far outside the contour.
constexpr double kStartsOutside = 2.0;

std::size_t ring_size(double delay_s, double picture_s) {
  return static_cast<std::size_t>(std::ceil(delay_s / picture_s)) + 3;
}

// The lengths along a path up to each point of its simplified form, whose points are points of the
// path.
std::vector<double> lengths_along(const HandPath& whole, const HandPath& simple) {
  const std::vector<double> lengths_m = whole.lengths_m();
  std::vector<double> kept_m;
  std::size_t i = 0;
  for (const HandPath::Point& point : simple.points) {
    while (i + 1 < whole.points.size() && whole.points[i].p_m != point.p_m) ++i;
    kept_m.push_back(lengths_m[i++]);
  }
  return kept_m;
}

// The number that corresponds to x if `from` maps to `to`, evenly in between. Both ascend.
double mapped(double x, const std::vector<double>& from, const std::vector<double>& to) {
  const std::size_t i = leg_at(from, x);
  const double leg = from[i + 1] - from[i];
  const double part = leg > 0.0 ? std::clamp((x - from[i]) / leg, 0.0, 1.0) : 0.0;
  return to[i] + part * (to[i + 1] - to[i]);
}

std::vector<double> corners_of(const HandPath& path, const std::vector<double>& lengths_m) {
  std::vector<double> corners_m;
  for (std::size_t i = 1; i + 1 < path.points.size(); ++i) {
    if (std::abs(path.points[i].fold_rad) >= kSharpCornerRad) corners_m.push_back(lengths_m[i]);
  }
  return corners_m;
}

}  // namespace

OperatorHand::OperatorHand(const TrialWay& way, const OperatorParameters& person,
                           Following following, const TrialSettings& settings,
                           double proxy_radius_m, Recovery recovery)
    : person_(person),
      following_(following),
      recovery_(recovery),
      picture_s_(1.0 / settings.display_Hz),
      sphere_radius_m_(settings.sphere_radius_m),
      proxy_radius_m_(proxy_radius_m),
      place_(way.path, way.green_along_m, settings.sphere_radius_m),
      path_(simplified(way.path, kSmallForHand * person.press_depth_m)),
      lengths_m_(path_.lengths_m()),
      way_lengths_m_(lengths_along(way.path, path_)),
      track_(path_, person.press_depth_m),
      corners_m_(corners_of(path_, lengths_m_)),
      green_m_(way.green_m),
      red_along_m_(mapped(way.red_along_m, way_lengths_m_, lengths_m_)),
      pictures_(ring_size(person.sight_delay_s, picture_s_)) {
  const double green_along_m = seen_along_m();
  start_m_ = way.green_m -
             (kStartsOutside * person_.press_depth_m + proxy_radius_m_) * inward_at(green_along_m);
  reach_m_ = kArm_m;
  for (const HandPath::Point& point : path_.points) {
    reach_m_ = std::max(reach_m_, kArm_m + (point.p_m - start_m_).norm());
  }
  plan_m_ = start_m_;
  detour_.at_m = start_m_;
  detour_.goal_along_m = green_along_m;
  detour_.speed_m_per_s = person_.speed_m_per_s;
}

Vec3 OperatorHand::inward_at(double along_m) const {
  return path_.points[leg_at(lengths_m_, along_m)].inward;
}

// A point beside the contour, inside it by inward_m.
Vec3 OperatorHand::beside_m(double along_m, double inward_m) const {
  return point_along(path_, lengths_m_, along_m) + inward_m * inward_at(along_m);
}

double OperatorHand::seen_along_m() const {
  return mapped(place_.along_m(), way_lengths_m_, lengths_m_);
}

HandTarget OperatorHand::target(double time_s, const ScenePose& T_device_scene,
                                const TickRecord& last) noexcept {
  const double dt_s = time_s - last_time_s_;
  last_time_s_ = time_s;
  if (time_s >= static_cast<double>(taken_) * picture_s_) {
    take_picture(time_s, T_device_scene, last);
  }
  look(time_s);
  HandTarget target;
  if (seen_ == 0) {  // the person has seen nothing yet and rests
    target.position_m = T_device_scene.point(start_m_);
    return target;
  }
  const Aim aim = is_following_ ? follow(dt_s) : go_back(dt_s);
  const Vec3 to_centre = -proxy_radius_m_ * inward_at(seen_along_m());
  const ScenePose believed = believed_pose(time_s);
  target.position_m = believed.point(aim.p_m + to_centre);
  target.velocity_m_per_s = believed.direction(aim.velocity_m_per_s);
  return misjudges_turn() ? within_reach(target) : target;
}

// Whether the person believes in another orientation of the scene than the picture's.
bool OperatorHand::misjudges_turn() const {
  const Picture& newest = pictures_[(seen_ - 1) % pictures_.size()];
  return view_of(following_) == View::kStill && following_ != Following::kAdaptsWhole &&
         has_turned(first_pose_, newest.T_device_scene);
}

HandTarget OperatorHand::within_reach(const HandTarget& target) const {
  const Vec3 from_m = first_pose_.point(start_m_);
  const Vec3 way_m = target.position_m - from_m;
  const double distance_m = way_m.norm();
  if (distance_m <= reach_m_) return target;
  HandTarget reached = target;
  reached.position_m = from_m + reach_m_ / distance_m * way_m;
  reached.velocity_m_per_s.setZero();
  return reached;
}

// A picture shows the scene after the rotation of its tick, as the display does.
void OperatorHand::take_picture(double time_s, const ScenePose& T_device_scene,
                                const TickRecord& last) {
  if (taken_ == 0) first_pose_ = T_device_scene;
  Picture& picture = pictures_[taken_ % pictures_.size()];
  picture.time_s = time_s;
  picture.T_device_scene = T_device_scene;
  picture.felt_device_m = taken_ > 0 ? vec3(last.device_m) : T_device_scene.point(start_m_);
  const Vec3 proxy_scene_m = taken_ > 0 ? vec3(last.proxy_scene_m) : start_m_;
  const Vec3 device_scene_m =
      taken_ > 0 ? T_device_scene.inverse_point(picture.felt_device_m) : start_m_;
  picture.seen =
      seen_picture(view_of(following_), first_pose_, T_device_scene, proxy_scene_m, device_scene_m);
  picture.contact = last.contact != 0;
  picture.plan_scene_m = plan_m_;
  ++taken_;
}

void OperatorHand::look(double time_s) {
  while (seen_ < taken_) {
    const Picture& next = pictures_[seen_ % pictures_.size()];
    if (next.time_s > time_s - person_.sight_delay_s) return;
    ++seen_;
    see(next);
  }
}

void OperatorHand::see(const Picture& picture) {
  const Vec3 outward = picture.seen.proxy_scene_m - picture.seen.device_scene_m;
  const bool is_apart = !outward.isZero(0.0);
  const Vec3 contact_m =
      is_apart ? Vec3(picture.seen.proxy_scene_m - proxy_radius_m_ * outward.normalized())
               : picture.seen.proxy_scene_m;
  if (!has_begun_) {
    has_begun_ = picture.contact && (contact_m - green_m_).norm() <= sphere_radius_m_;
  }
  const double before_m = seen_along_m();
  const bool is_good = has_begun_ && picture.contact && place_.see(contact_m, outward);
  const bool passed_corner = has_corner_between(before_m, seen_along_m());
  saw_wrong_part_ = picture.contact && !is_good;
  const bool lost_contact = saw_contact_ && !picture.contact;
  saw_contact_ = picture.contact;
  const bool replans =
      following_ == Following::kReplan && picture.time_s - held_since_s_ >= person_.replan_s;
  const bool thaws = following_ == Following::kFrozen && (lost_contact || passed_corner);
  if (seen_ == 1 || replans || thaws) {
    held_pose_ = picture.seen.T_picture_scene;
    held_since_s_ = picture.time_s;
  }
  if (is_good) {
    lost_s_ = 0.0;
    if (!is_following_) resume();
  } else {
    if (has_begun_) lost_s_ += picture_s_;
    if (is_following_ && lost_s_ >= (is_in_corner() ? kPatienceInCorner_s : kPatience_s)) lose();
  }
}

ScenePose OperatorHand::believed_pose(double time_s) const {
  const Picture& newest = pictures_[(seen_ - 1) % pictures_.size()];
  if (view_of(following_) == View::kStill) {
    return adapted_pose(first_pose_, newest.T_device_scene, newest.seen.device_scene_m,
                        newest.felt_device_m, adapted_share(following_));
  }
  if (following_ == Following::kReplan || following_ == Following::kFrozen) return held_pose_;
  if (following_ == Following::kDelayed || seen_ < 2) return newest.seen.T_picture_scene;
  const Picture& previous = pictures_[(seen_ - 2) % pictures_.size()];
  const Eigen::AngleAxisd turned(newest.seen.T_picture_scene.rotation *
                                 previous.seen.T_picture_scene.rotation.conjugate());
  const double pictures = (time_s - newest.time_s) / picture_s_;
  return turned_about(newest.seen.T_picture_scene, newest.seen.proxy_scene_m,
                      {turned.axis(), pictures * turned.angle()});
}

bool OperatorHand::has_corner_between(double first_m, double last_m) const {
  const auto corner = std::lower_bound(corners_m_.begin(), corners_m_.end(), first_m);
  return corner != corners_m_.end() && *corner <= last_m;
}

// Whether the target has turned, or turns, at a corner that the seen contact has not passed.
bool OperatorHand::is_in_corner() const {
  return has_corner_between(seen_along_m(), target_along_m());
}

double OperatorHand::pace_m_per_s() const {
  const Picture& newest = pictures_[(seen_ - 1) % pictures_.size()];
  const double depth_m = (newest.seen.device_scene_m - newest.seen.proxy_scene_m).norm();
  const double deeper_m = std::max(0.0, depth_m - person_.press_depth_m);
  const double comfortable_m = person_.comfortable_depth_m;
  const double pace = person_.speed_m_per_s * comfortable_m / std::max(comfortable_m, deeper_m);
  const double seen_m = seen_along_m();
  const bool is_at_corner = saw_contact_ && has_corner_between(seen_m, seen_m + kSeesCorner_m);
  return is_at_corner ? std::min(pace, kPaceAtCorner * person_.speed_m_per_s) : pace;
}

OperatorHand::Aim OperatorHand::follow(double dt_s) {
  double speed_m_per_s = pace_m_per_s();
  const double lead_m = kMostLead_m + speed_m_per_s * person_.sight_delay_s +
                        (is_in_corner() ? kMoreLeadInCorner * person_.press_depth_m : 0.0);
  const double along_m = target_along_m();
  if (along_m - seen_along_m() > lead_m || along_m >= red_along_m_) speed_m_per_s = 0.0;
  advance(speed_m_per_s * dt_s);
  const TargetTrack::Waypoint& from = track_.waypoints()[leg_];
  const Vec3 direction = (track_.waypoints()[leg_ + 1].p_m - from.p_m).normalized();
  plan_m_ = from.p_m + (travelled_m_ - from.track_m) * direction;
  correct(direction, dt_s);
  return {plan_m_ + correction_m_, speed_m_per_s * direction};
}

void OperatorHand::advance(double step_m) {
  const auto& waypoints = track_.waypoints();
  travelled_m_ = std::min(travelled_m_ + step_m, track_.length_m());
  while (leg_ + 2 < waypoints.size() && travelled_m_ >= waypoints[leg_ + 1].track_m) ++leg_;
}

// The correction of an earlier leg is projected onto the present one.
void OperatorHand::correct(const Vec3& direction, double dt_s) {
  const Picture& newest = pictures_[(seen_ - 1) % pictures_.size()];
  const double lag_m = (newest.plan_scene_m - newest.seen.device_scene_m).dot(direction);
  const double along_m = correction_m_.dot(direction) + person_.gain_per_s * lag_m * dt_s;
  correction_m_ = std::clamp(along_m, -kMostCorrection_m, kMostCorrection_m) * direction;
}

// A hand that is far from the place, touches a wrong part or is lost again goes by the outside.
void OperatorHand::lose() {
  if (recovery_ == Recovery::kOff) return;
  ++recoveries_;
  const Picture& newest = pictures_[(seen_ - 1) % pictures_.size()];
  const double nearest_m = nearest_along_m(path_, lengths_m_, newest.seen.proxy_scene_m);
  detour_.goal_along_m = std::min(seen_along_m() + kGoesOn_m, red_along_m_);
  detour_.is_outside = saw_wrong_part_ || !is_following_ ||
                       std::abs(nearest_m - detour_.goal_along_m) > ContourPlace::kReach_m;
  detour_.outside_m = nearest_m;
  detour_.at_m = plan_m_ + correction_m_;
  detour_.speed_m_per_s = kHaste * person_.speed_m_per_s;
  detour_.waited_s = 0.0;
  is_following_ = false;
  correction_m_.setZero();
  lost_s_ = 0.0;
}

// Returns whether the point is reached in this step.
bool OperatorHand::go_towards(const Vec3& to_m, double step_m) {
  const Vec3 left_m = to_m - detour_.at_m;
  const double distance_m = left_m.norm();
  if (distance_m <= step_m) {
    detour_.at_m = to_m;
    return true;
  }
  detour_.at_m += step_m / distance_m * left_m;
  return false;
}

OperatorHand::Aim OperatorHand::go_back(double dt_s) {
  Detour& d = detour_;
  const double step_m = d.speed_m_per_s * dt_s;
  const Vec3 before_m = d.at_m;
  if (d.is_outside) {
    const double outside_m = -kOutside * person_.press_depth_m;
    if (go_towards(beside_m(d.outside_m, outside_m), step_m)) {
      const double left_m = d.goal_along_m - d.outside_m;
      d.is_outside = left_m != 0.0;
      d.outside_m += std::clamp(left_m, -kStride_m, kStride_m);
    }
  } else if (go_towards(beside_m(d.goal_along_m, person_.press_depth_m), step_m)) {
    if (has_begun_) d.waited_s += dt_s;
    if (d.waited_s >= kPatience_s + person_.sight_delay_s) lose();
  }
  plan_m_ = d.at_m;
  const Vec3 velocity_m_per_s = dt_s > 0.0 ? Vec3((d.at_m - before_m) / dt_s) : Vec3(Vec3::Zero());
  return {plan_m_, velocity_m_per_s};
}

// The person sees contact with the contour and follows it from there.
void OperatorHand::resume() {
  is_following_ = true;
  correction_m_.setZero();
  const double along_m = seen_along_m();
  leg_ = track_.leg_at(along_m);
  travelled_m_ = track_.track_m(leg_, along_m);
}

}  // namespace palpate
