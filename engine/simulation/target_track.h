#pragma once

// The track of the hand's target point while the hand follows a path.

#include <cstddef>
#include <numbers>
#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"

namespace palpate {

// A path that turns by at least this angle has a corner.
inline constexpr double kSharpCornerRad = std::numbers::pi / 4;

// The polyline that the target point of a hand follows, at the press depth inside the walls of a
// path. At a convex edge sharper than 45 deg the target continues past the edge by the press depth
// before it turns. If the target moved only to the edge along the old wall, the hand would press
// ever deeper and never pass the edge; simulations show this at corners of 90 deg and less. In a
// concave corner the target lies inside both walls.
class TargetTrack {
 public:
  struct Waypoint {
    Vec3 p_m;
    Vec3 inward;     // direction in which a wall supports the hand on the leg that begins here
    double along_m;  // the corresponding length along the path
    double track_m;  // length along the track from the first waypoint
    bool is_turn = false;  // the target waits here until the proxy arrives
  };

  TargetTrack(const HandPath& path, double press_depth_m);

  const std::vector<Waypoint>& waypoints() const { return waypoints_; }
  double length_m() const { return waypoints_.back().track_m; }

  // The index of the first waypoint of the last leg that begins at or before this length along the
  // path.
  std::size_t leg_at(double along_m) const;

  // Converts a length along the track to the corresponding length along the path, and back. leg:
  // the leg of the track that contains the point at this length. Between the ends of a leg, one
  // length is a linear function of the other.
  double along_m(std::size_t leg, double track_m) const;
  double track_m(std::size_t leg, double along_m) const;

 private:
  struct Corner;
  void add(const Vec3& p_m, const Vec3& inward, double along_m, bool is_turn = false);
  void add_corner(const Corner& corner);
  void add_edge(const Corner& corner);

  double depth_m_;
  std::vector<Waypoint> waypoints_;
};

}  // namespace palpate
