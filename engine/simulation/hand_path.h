#pragma once

// What a hand follows: a path over the surfaces of a scene.

#include <numbers>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// A path that turns by more turns back, and walls turned by more face against each other: which way
// round, over an edge or in a slit, their directions alone do not tell.
inline constexpr double kTurnsBackRad = 0.95 * std::numbers::pi;

// Straight legs, each along a wall that the hand presses on. Scene frame.
struct HandPath {
  struct Point {
    Vec3 p_m;
    Vec3 inward;            // unit, into the wall of the leg that begins here
    double fold_rad = 0.0;  // by which this wall is turned from the one before: > 0 over an edge
                            // that sticks out, < 0 into a corner
    bool is_turn = false;   // the hand takes another heading here
  };
  // Two or more where there is anything to follow. The last one repeats the wall before it.
  std::vector<Point> points;

  // Along the path up to each point.
  std::vector<double> lengths_m() const;
};

// The same with the walls touched from behind.
HandPath other_side(HandPath path);

// A simpler path: legs stand for several where all points between are within tolerance_m of them
// and it does not turn back; the wall of such a leg is their mean. Turns stay.
HandPath simplified(const HandPath& path, double tolerance_m);

// At equal distances of at most spacing_m along the path, its ends included.
std::vector<Vec3> places_along(const HandPath& path, double spacing_m);

}  // namespace palpate
