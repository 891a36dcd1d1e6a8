// The motion of a sphere round edges and vertices.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "haptics/proxy/god_object_steps.h"

namespace palpate {
namespace {

// Error of a sphere's position on a feature, relative to the scene's size: the positions of sphere
// and feature are rounded.
constexpr double kTurnRoundoff = 8 * std::numeric_limits<double>::epsilon();

// A slow proxy halves a blocked turn at most this many times, and only while at least this part of
// the turn is free.
constexpr int kMostHalvedTurns = 4;
constexpr double kLeastTurn = 1.0 / 32;

// A contact normal lies in the plane of motion if its component out of the plane is at most this.
constexpr double kOutOfPlane = 64 * std::numeric_limits<double>::epsilon();

// The least sine of the angle between an edge and the plane of motion at which a sphere moves round
// the edge: half the digits of double. An edge with a smaller angle has nearly one normal in that
// plane.
constexpr double kLeastLean = 1e-8;

// Writes the corners of the tangents from one contact of a sphere to another contact with the same
// face, for a centre at the distance `reach` from the feature. Returns their number.
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

// The arc on which the centre of a sphere moves round the edge or vertex of a contact towards the
// goal, up to the place that is nearest to the goal or up to a right angle. Nullopt if there is no
// such arc: the goal is on the other side of the feature, or the feature is an edge along the plane
// of motion.
std::optional<RollArc> GodObject::arc_round(const FaceContact& now) const {
  RollArc arc;
  const double reach_m = tracer_.radius_m() + scale().stop_m;
  const bool is_edge = now.feature == TriangleFeature::kEdge;
  arc.edge = is_edge ? tracer_.edge_direction(now) : Vec3(Vec3::Zero());
  arc.feature_point = arc.centre = now.feature_point;
  if (!motion_plane_) {
    Vec3 out = goal_ - now.feature_point;
    const Vec3 along = out.dot(arc.edge) * arc.edge;
    if (is_edge) {
      arc.drift = tracer_.contact_at(now.face, proxy_ + along, now.normal).feature_point -
                  now.feature_point;
    }
    out = (out - along).normalized();
    const double cosine = out.dot(now.normal);
    const Vec3 across = out - cosine * now.normal;
    const double sine = across.norm();
    if (cosine <= 0.0 || sine <= kCancelledNormal) return std::nullopt;
    arc.u = reach_m * now.normal;
    arc.v = reach_m / sine * across;
    arc.angle_rad = std::atan2(sine, cosine);
    return arc;
  }
  // The section of the plane of motion with the sphere or cylinder on which the centre moves: a
  // circle or an ellipse. The plane crosses the edge at the centre of the ellipse.
  const Vec3& n = motion_plane_->normal();
  const double height_m = (proxy_ - now.feature_point).dot(n);
  const double lean = is_edge ? std::abs(n.dot(arc.edge)) : 1.0;  // of the edge against the plane
  if (lean <= kLeastLean || (!is_edge && std::abs(height_m) >= reach_m)) return std::nullopt;
  arc.centre += is_edge ? Vec3(height_m / n.dot(arc.edge) * arc.edge) : Vec3(height_m * n);
  const double least_m = is_edge ? reach_m : std::sqrt((reach_m - height_m) * (reach_m + height_m));
  const Vec3 from_centre = proxy_ - arc.centre;
  // The axes of the ellipse: across the edge, and along its projection.
  const Vec3 side = is_edge && lean < 1.0 - kOutOfPlane ? Vec3(n.cross(arc.edge)) : from_centre;
  const Vec3 minor = (side - side.dot(n) * n).normalized();
  const Vec3 major = n.cross(minor);
  const double start_rad = std::atan2(lean * from_centre.dot(major), from_centre.dot(minor));
  const double c = std::cos(start_rad);
  const double s = std::sin(start_rad);
  arc.u = least_m * (c * minor + s / lean * major);
  arc.v = least_m * (c / lean * major - s * minor);
  if (arc.v.dot(goal_ - proxy_) < 0.0) arc.v = -arc.v;
  arc.angle_rad = 0.5 * std::numbers::pi;
  return arc;
}

// Moves a sphere along a part of an arc, on tangents. False if an obstacle blocks one of them or if
// the end is farther from the goal.
bool GodObject::rolls_along(const RollArc& arc, double part) {
  const double turn_rad = part * arc.angle_rad;
  const double count = std::max(1.0, std::ceil(turn_rad / kRollTurn_rad));
  const double stretch = 1.0 / std::cos(0.5 * turn_rad / count);
  std::array<Vec3, kMostRollCorners + 1> corners;
  std::size_t corner_count = 0;
  for (double k = 0.5; k < count; k += 1.0) {
    corners[corner_count++] = point_in_motion_plane(arc.place(k / count * part, stretch));
  }
  corners[corner_count++] = point_in_motion_plane(arc.place(part));
  const auto path = std::span(corners).first(corner_count);
  if ((path.back() - goal_).squaredNorm() > (proxy_ - goal_).squaredNorm()) return false;
  if (part_free(path) < 1.0) return false;
  for (const Vec3& corner : path) commit(corner);
  step_.set_earlier();
  return true;
}

// Moves a sphere that only an edge or vertex holds round the feature to its final position, which
// lies straight out from the feature through the goal. The centre is held by a curved surface, so
// that slides along tangent planes would need many steps, the more the nearer the goal is to the
// feature. False if no feature holds the sphere, if an obstacle blocks the path, or if the gain is
// too small: if the goal is on the feature, all positions round it are equally near.
bool GodObject::roll_to_answer() {
  if (step_.active_count() != 1) return false;
  if (goal_waits_ && !may_gain_by(NoFriction{}, step_.displacement_m())) return false;
  const FaceContact now = step_.active_contact(0);
  if (now.feature == TriangleFeature::kFace) return false;
  FaceContact answer = tracer_.contact_at(now.face, goal_, now.normal);
  const auto leaves_plane = [&](const Vec3& normal) {
    return motion_plane_ && std::abs(normal.dot(motion_plane_->normal())) > kOutOfPlane;
  };
  if (leaves_plane(now.normal) || leaves_plane(answer.normal) || is_same_place(now, answer)) {
    return false;
  }
  if (!goes_round(now, answer, tracer_.radius_m() + scale().stop_m)) return false;
  step_.clear_planes();
  answer.clearance_m = scale().stop_m;
  add_plane(answer);
  step_.solve_by_first();
  return true;
}

// Moves the proxy round a feature from one contact to another, for a centre at the distance `reach`
// from the feature, by a right angle at most. A slow proxy moves round a part of the angle if an
// obstacle blocks the rest. The distance to the goal falls along the whole arc. The tangents have
// corners a little farther out, so all of them are committed or none. Writes the final contact to
// `to`.
bool GodObject::goes_round(const FaceContact& from, FaceContact& to, double reach) {
  if (to.normal.dot(from.normal) <= 0.0) {
    Vec3 across = to.normal - to.normal.dot(from.normal) * from.normal;
    if (motion_plane_) across = motion_plane_->part_of(across);
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
    if (motion_plane_) {
      for (Vec3& corner : std::span(corners).first(count + 1))
        corner = point_in_motion_plane(corner);
    }
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

// The part of the path along these corners that is free. 0 if the path gets too far from the goal.
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

// Moves a sphere round the two features that it touched last. Otherwise it would move round one and
// the other in turn, or slide along the line of their planes and leave the features at once.
bool GodObject::roll_between_last_two() {
  if (step_.active_count() == 0 || motion_plane_) return false;
  const FaceContact now = step_.active_contact(0);
  if (now.feature == TriangleFeature::kFace) return false;
  const std::optional<FaceContact> last = extrapolation_.go_round(now);
  if (step_.active_count() == 2) return roll_between(step_.active_contact(1), now);
  return step_.active_count() == 1 && last && roll_between(*last, now);
}

// Moves a sphere that touches two points. Its centre stays on a circle about the line through the
// points; it moves along the circle towards the position nearest to the goal.
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
  step_.clear_planes();
  for (const FaceContact& contact : {one, other}) {
    add_plane(tracer_.contact_at(contact.face, proxy_, contact.normal));
  }
  step_.set_current();
  step_.solve_by_all(Vec3::Zero());
  return true;
}

// Whether two contacts of a sphere count as the same: they touch the same point of a feature to
// within a stand-off, and the gain of a turn from one to the other, lag * angle^2, is negligible.
bool GodObject::is_same_place(const FaceContact& a, const FaceContact& b) const {
  const double turn = (a.normal - b.normal).norm();
  const double turned_m = turn * tracer_.radius_m();
  if (turned_m > scale().stand_off_m) return false;
  const double gain_m = turn * turn * (proxy_ - goal_).norm();
  return gain_m <= little_m() || turned_m <= kTurnRoundoff * world_->size_m();
}

}  // namespace palpate
