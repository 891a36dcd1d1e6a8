#pragma once

// Where a hand goes that follows a path.

#include <cstddef>
#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"

namespace palpate {

// The way of a hand that presses on the walls it follows: a polyline some depth inside. Over an
// edge sharper than 45 deg it goes on across the edge by its press depth before it turns: aiming
// along the old wall only, it would press ever deeper and never come round (numerics: corners of
// 90 deg and less). In a concave corner it presses into both walls.
class HandWay {
 public:
  struct Waypoint {
    Vec3 p_m;
    Vec3 inward;           // of the leg that begins here: the hand is held by a wall along it
    double along_m;        // the path: of the place that belongs to it
    double way_m;          // from the first waypoint
    bool is_turn = false;  // to be gone on from when the proxy is there
  };

  HandWay(const HandPath& path, double press_depth_m);

  const std::vector<Waypoint>& waypoints() const { return waypoints_; }
  double length_m() const { return waypoints_.back().way_m; }

  // The leg, by its first waypoint, that begins at a place of the path or before it.
  std::size_t leg_at(double along_m) const;

 private:
  struct Corner;
  void add(const Vec3& p_m, const Vec3& inward, double along_m, bool is_turn = false);
  void add_corner(const Corner& corner);
  void add_edge(const Corner& corner);

  double depth_m_;
  std::vector<Waypoint> waypoints_;
};

}  // namespace palpate
