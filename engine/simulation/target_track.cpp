#include "engine/simulation/target_track.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// In press depths: the distance beyond an edge at which the hand is on the new wall. kMostAslant
// limits the factor by which an oblique path lengthens this distance.
constexpr double kBeyondEdge = 2.0;
constexpr double kMostAslant = 2.0;

// The least cosine between the path and the direction across an edge of a path that crosses it
// perpendicularly.
constexpr double kStraightOver = 0.999;

// The component of v perpendicular to a unit vector, normalised; `otherwise` if v is parallel to
// it.
Vec3 unit_across(const Vec3& v, const Vec3& unit, const Vec3& otherwise) {
  const Vec3 across = v - v.dot(unit) * unit;
  return across.isZero(0.0) ? otherwise : Vec3(across.normalized());
}

}  // namespace

struct TargetTrack::Corner {
  Vec3 p_m;
  Vec3 tangent_in, tangent_out;
  Vec3 inward_in, inward_out;
  double fold_rad;
  bool is_turn;
  double along_m;
  double length_out_m;  // of the leg from here
};

TargetTrack::TargetTrack(const HandPath& path, double press_depth_m) : depth_m_(press_depth_m) {
  const auto& points = path.points;
  const auto tangent = [&](std::size_t i) {
    return Vec3((points[i + 1].p_m - points[i].p_m).normalized());
  };
  const std::vector<double> lengths_m = path.lengths_m();
  add(points.front().p_m + depth_m_ * points.front().inward, points.front().inward, 0.0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    add_corner({points[i].p_m, tangent(i - 1), tangent(i), points[i - 1].inward, points[i].inward,
                points[i].fold_rad, points[i].is_turn, lengths_m[i],
                lengths_m[i + 1] - lengths_m[i]});
  }
  const std::size_t last = points.size() - 1;
  add(points[last].p_m + depth_m_ * points[last].inward, points[last].inward, lengths_m[last]);
}

void TargetTrack::add(const Vec3& p_m, const Vec3& inward, double along_m, bool is_turn) {
  const double track_m =
      waypoints_.empty() ? 0.0 : waypoints_.back().track_m + (p_m - waypoints_.back().p_m).norm();
  waypoints_.push_back({p_m, inward, along_m, track_m, is_turn});
}

void TargetTrack::add_corner(const Corner& c) {
  if (c.fold_rad >= kSharpCornerRad) {
    add_edge(c);
    return;
  }
  // The two planes at press depth meet on the bisector, at a spike far away. In a concave corner
  // twice the depth is enough to press on both walls. At the end of a slit the hand presses
  // straight ahead.
  const Vec3 middle = c.inward_in + c.inward_out;
  const bool is_slit = c.fold_rad < -kTurnsBackRad;
  const Vec3 bisector = is_slit ? c.tangent_in : Vec3(middle.normalized());
  const double reach = is_slit ? depth_m_ : depth_m_ / std::max(0.5, bisector.dot(c.inward_in));
  add(c.p_m + reach * bisector, c.inward_out, c.along_m, c.is_turn);
}

void TargetTrack::add_edge(const Corner& c) {
  const bool turns_back = c.fold_rad > kTurnsBackRad;
  const Vec3 over =
      turns_back ? c.tangent_in : unit_across(-c.inward_out, c.inward_in, c.tangent_in);
  const Vec3 down =
      turns_back ? c.tangent_out : unit_across(c.inward_in, c.inward_out, c.tangent_out);
  const double slowness = 1.0 / std::max(1.0 / kMostAslant, c.tangent_out.dot(down));
  const double beyond_m =
      std::clamp(0.5 * c.length_out_m, depth_m_ * slowness, kBeyondEdge * depth_m_ * slowness);
  const Vec3 beyond = beyond_m * c.tangent_out;
  const Vec3 between = c.inward_in + c.inward_out;
  // An oblique path is crossed perpendicular to the edge: along the path, the hand would pass the
  // edge before the path does.
  if (over.dot(c.tangent_in) < kStraightOver) {
    add(c.p_m + depth_m_ * c.inward_in, between, c.along_m);
  }
  add(c.p_m + depth_m_ * (c.inward_in + over), between, c.along_m, true);
  // On a part thinner than the press depth the hand continues in front of the wall: a target inside
  // it would lie on its other side.
  if (turns_back) add(c.p_m + beyond - depth_m_ * c.inward_out, c.inward_out, c.along_m);
  add(c.p_m + beyond + depth_m_ * c.inward_out, c.inward_out, c.along_m);
}

std::size_t TargetTrack::leg_at(double along_m) const {
  const auto after = std::upper_bound(
      waypoints_.begin() + 1, waypoints_.end() - 1, along_m,
      [](double along, const Waypoint& waypoint) { return along < waypoint.along_m; });
  return static_cast<std::size_t>(after - waypoints_.begin()) - 1;
}

double TargetTrack::along_m(std::size_t leg, double track_m) const {
  const Waypoint& from = waypoints_[leg];
  const Waypoint& to = waypoints_[leg + 1];
  const double leg_m = to.track_m - from.track_m;
  const double part = leg_m > 0.0 ? (track_m - from.track_m) / leg_m : 1.0;
  return from.along_m + part * (to.along_m - from.along_m);
}

double TargetTrack::track_m(std::size_t leg, double along_m) const {
  const Waypoint& from = waypoints_[leg];
  const Waypoint& to = waypoints_[leg + 1];
  const double walls_m = to.along_m - from.along_m;
  const double part =
      walls_m > 0.0 ? std::clamp((along_m - from.along_m) / walls_m, 0.0, 1.0) : 0.0;
  return from.track_m + part * (to.track_m - from.track_m);
}

}  // namespace palpate
