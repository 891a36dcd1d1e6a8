#pragma once

// The path over the surfaces of a scene that a simulated hand follows.

#include <cstddef>
#include <numbers>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// A path turns back if it turns by more than this angle. Two walls face each other if their
// directions differ by more than this angle; the directions alone then do not show whether the path
// goes over an edge or into a slit.
inline constexpr double kTurnsBackRad = 0.95 * std::numbers::pi;

// Straight legs, each along a wall that the hand presses on. Scene frame.
struct HandPath {
  struct Point {
    Vec3 p_m;
    Vec3 inward;            // unit vector into the wall of the leg that begins here
    double fold_rad = 0.0;  // angle from the previous wall to this one: > 0 over a convex edge, < 0
                            // in a concave corner
    bool is_turn = false;   // the path takes a new heading here
  };
  // Two or more points unless the path is empty. The last point repeats the wall of the last leg.
  std::vector<Point> points;

  // The length of the path up to each point.
  std::vector<double> lengths_m() const;
};

// The leg of a path at a length along it; lengths_m: HandPath::lengths_m().
std::size_t leg_at(const std::vector<double>& lengths_m, double along_m);
// The point at this length along a path.
Vec3 point_along(const HandPath& path, const std::vector<double>& lengths_m, double along_m);
// The length along a path at which the path is nearest to p; the first of several. O(points).
double nearest_along_m(const HandPath& path, const std::vector<double>& lengths_m, const Vec3& p_m);

// Returns `path` with its walls touched from behind.
HandPath other_side(HandPath path);

// A path that ends where it begins, followed `laps` times, laps >= 1.
HandPath repeated(const HandPath& path, int laps);

// A path followed `laps` times, laps >= 1, in its direction and against it by turns, along the same
// side of its walls. The path takes a new heading at its ends.
HandPath to_and_fro(const HandPath& path, int laps);

// A simpler path. One leg replaces several if all points between its ends are within tolerance_m of
// it and the path does not turn back. The wall of the new leg is the mean of the walls of the legs
// that it replaces. Turns are kept.
HandPath simplified(const HandPath& path, double tolerance_m);

// Points at equal distances of at most spacing_m along the path, including both ends.
std::vector<Vec3> places_along(const HandPath& path, double spacing_m);

}  // namespace palpate
