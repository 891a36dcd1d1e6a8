// How a sphere goes round edges and vertices.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "haptics/proxy/god_object_steps.h"

namespace palpate {
namespace {

// A sphere on a feature is so far from where it is to be, of the scene's size: its place, and that
// of the feature, are rounded.
constexpr double kTurnRoundoff = 8 * std::numeric_limits<double>::epsilon();

// A sphere goes round a feature along tangents that turn by so much at a time at most: their
// corners are 0.8 % of the radius off the arc.
constexpr double kRollTurn_rad = 0.25;

// A slow proxy halves a turn that is not free so often, if there is any use in it: if so much of it
// is free.
constexpr int kMostHalvedTurns = 4;
constexpr double kLeastTurn = 1.0 / 32;

// A contact normal with a larger part than this out of the plane of motion does not belong to it.
constexpr double kOutOfPlane = 64 * std::numeric_limits<double>::epsilon();

// The corners of the tangents from one contact of a sphere round to another with the same face, for
// a centre that keeps `reach` from the feature. Returns how many there are.
std::size_t tangents_round(const FaceContact& from, const FaceContact& to, double reach,
                           std::array<Vec3, kMostRollCorners + 1>& corners) {
  const Vec3 across = (to.normal - to.normal.dot(from.normal) * from.normal).normalized();
  const double angle_rad = std::atan2(to.normal.dot(across), to.normal.dot(from.normal));
  const double count = std::ceil(angle_rad / kRollTurn_rad);
  const double radius = reach / std::cos(0.5 * angle_rad / count);
  for (double k = 0.5; k < count; k += 1.0) {
    const double turn_rad = k / count * angle_rad;
    const Vec3 feature = from.feature_point + k / count * (to.feature_point - from.feature_point);
    corners[static_cast<std::size_t>(k)] =
        feature + radius * (std::cos(turn_rad) * from.normal + std::sin(turn_rad) * across);
  }
  return static_cast<std::size_t>(count);
}

}  // namespace

// A sphere held by an edge or vertex alone is held by a curved surface, and a slide along its
// tangent plane that drops back converges step by step, the slower the nearer the goal is to the
// feature. Instead, the sphere goes round to the answer, which is straight out from the feature
// through the goal. False if there is nothing to roll over, or something in the way, or no use in
// it: round a feature that is the goal, all places are as near.
bool GodObject::roll_to_answer() {
  if (projection_.active_count != 1) return false;
  if (goal_waits_ && !may_gain_by(projection_.displacement_m)) return false;
  const FaceContact now = contacts_[projection_.active[0]];
  if (now.feature == TriangleFeature::kFace) return false;
  FaceContact answer = tracer_.contact_at(now.face, goal_, now.normal);
  const auto leaves_plane = [&](const Vec3& normal) {
    return motion_plane_normal_ && std::abs(normal.dot(*motion_plane_normal_)) > kOutOfPlane;
  };
  if (leaves_plane(now.normal) || leaves_plane(answer.normal) || is_same_place(now, answer)) {
    return false;
  }
  if (!goes_round(now, answer, tracer_.radius_m() + scale().stop_m)) return false;
  plane_count_ = 0;
  answer.clearance_m = scale().stop_m;
  add_plane(answer);
  projection_.active[0] = 0;
  return true;
}

// Goes round from one contact to another, for a centre that keeps `reach` from the feature: by a
// right angle at most, and a slow proxy only a part of that if something is in the way of the rest.
// The distance to the goal falls all the way round; the tangents that are followed for it have
// corners a little farther out, so they are taken together or not at all. Tells in `to` where it
// ends.
bool GodObject::goes_round(const FaceContact& from, FaceContact& to, double reach) {
  if (to.normal.dot(from.normal) <= 0.0) {
    const Vec3 across = to.normal - to.normal.dot(from.normal) * from.normal;
    if (!is_slow_ || across.norm() <= kCancelledNormal) return false;
    to.normal = across.normalized();
    to.feature_point = from.feature_point;
  }
  std::array<Vec3, kMostRollCorners + 1> corners;
  for (int halved = 0; halved <= kMostHalvedTurns; ++halved) {
    const Vec3 target = to.feature_point + reach * to.normal;
    if ((target - goal_).squaredNorm() > (proxy_ - goal_).squaredNorm()) return false;
    if (is_same_place(from, to)) return false;
    const std::size_t count = tangents_round(from, to, reach, corners);
    corners[count] = target;
    const double part = part_free(std::span(corners).first(count + 1));
    if (part == 1.0) {
      for (const Vec3& corner : std::span(corners).first(count + 1)) commit(corner);
      return true;
    }
    if (!is_slow_ || part < kLeastTurn) return false;
    to.normal = (from.normal + to.normal).normalized();
    to.feature_point = 0.5 * (from.feature_point + to.feature_point);
  }
  return false;
}

// The part of the way along these corners that is free, and not too far from the goal.
double GodObject::part_free(std::span<const Vec3> corners) {
  const auto count = static_cast<double>(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& from = i == 0 ? proxy_ : corners[i - 1];
    if ((corners[i] - goal_).squaredNorm() > most_lag_m_ * most_lag_m_) return 0.0;
    const auto hit = tracer_.trace(from, corners[i]);
    if (hit) return std::min(static_cast<double>(i) + hit->fraction.value(), count - 0.5) / count;
  }
  return 1.0;
}

// A sphere between two edges or vertices goes round one and then the other, to and fro, or slides
// along the line of their planes, which it leaves at once.
bool GodObject::roll_between_last_two() {
  if (projection_.active_count == 0 || motion_plane_normal_) return false;
  const FaceContact now = contacts_[projection_.active[0]];
  if (now.feature == TriangleFeature::kFace) return false;
  const std::optional<FaceContact> last = last_round_;
  last_round_ = now;
  if (projection_.active_count == 2) return roll_between(contacts_[projection_.active[1]], now);
  return projection_.active_count == 1 && last && roll_between(*last, now);
}

// The places where it touches two points are a circle about the line through them. Goes round on
// it, towards what is nearest to the goal.
bool GodObject::roll_between(const FaceContact& one, const FaceContact& other) {
  const Vec3 axis = 0.5 * (other.feature_point - one.feature_point);
  const double reach = tracer_.radius_m() + scale().stop_m;
  const double radius2 = reach * reach - axis.squaredNorm();
  if (one.feature == TriangleFeature::kFace || axis.isZero(0.0) || radius2 <= 0.0) return false;
  const Vec3 centre = one.feature_point + axis;
  const auto on_circle = [&](const Vec3& p) {
    FaceContact contact = other;
    const Vec3 out = p - centre;
    contact.normal = (out - out.dot(axis) / axis.squaredNorm() * axis).normalized();
    contact.feature_point = centre;
    return contact;
  };
  FaceContact target = on_circle(goal_);
  if (!goes_round(on_circle(proxy_), target, std::sqrt(radius2))) return false;
  plane_count_ = 0;
  for (const FaceContact& contact : {one, other}) {
    add_plane(tracer_.contact_at(contact.face, proxy_, contact.normal));
  }
  planes_are_current_ = true;
  projection_ = {Vec3::Zero(), {0, 1, 2}, plane_count_, true};
  return true;
}

// Whether a sphere touches the same place of a curved feature in both contacts, and what a tangent
// gains on the way from one to the other, a turn's square of the lag, is little.
bool GodObject::is_same_place(const FaceContact& a, const FaceContact& b) const {
  const double turn = (a.normal - b.normal).norm();
  const double turned_m = turn * tracer_.radius_m();
  if (turned_m > scale().stand_off_m) return false;
  const double gain_m = turn * turn * (proxy_ - goal_).norm();
  return gain_m <= little_m() || turned_m <= kTurnRoundoff * world_->size_m();
}

}  // namespace palpate
