#pragma once

// Where a hand goes that follows a contour on one side of it.

#include <cstddef>
#include <vector>

#include "geometry/section.h"
#include "geometry/types.h"

namespace palpate {

// Opens a closed contour, so that it begins and ends in the middle of a segment: of the longest
// from whose middle nothing is near in front. curves: all that the plane cuts, the contour
// included. room_m: how much room there is to be; set to half of what there is where there is less.
// In front: on the right of the contour, seen from the tip of plane_normal. An open contour stays
// as it is.
std::vector<Vec3> open_contour(const Polyline& contour, const std::vector<Polyline>& curves,
                               const Vec3& plane_normal, double& room_m);

// The way of a hand that presses on the wall it follows: a polyline some depth inside. At a convex
// corner sharper than 45 deg it goes on along the old wall by its press depth before it turns:
// aiming along the old wall only, it would press ever deeper and never come round (numerics:
// corners of 90 deg and less). In a concave corner it presses into both walls.
class ContourWay {
 public:
  struct Waypoint {
    Vec3 p_m;
    double along_m;        // the contour: of the place that belongs to it
    double way_m;          // from the first waypoint
    bool is_turn = false;  // at a sharp corner, to be gone on from when the corner is reached
  };

  // contour_m: two points or more. whole_m: the contour that these are points of, in order; it
  // tells a spike from a slit where both turn right back. side: 1 presses to the left of it, seen
  // from the tip of plane_normal, -1 to the right.
  ContourWay(const std::vector<Vec3>& contour_m, const std::vector<Vec3>& whole_m,
             const Vec3& plane_normal, double press_depth_m, double side);

  const std::vector<Waypoint>& waypoints() const { return waypoints_; }
  double length_m() const { return waypoints_.back().way_m; }

  // The leg, by its first waypoint, that begins at a place of the contour or before it.
  std::size_t leg_at(double along_m) const;

 private:
  void add(const Vec3& p_m, double along_m, bool is_turn = false);
  void add_corner(const Vec3& corner_m, const Vec3& tangent_in, const Vec3& tangent_out,
                  double turn_rad, double along_m);

  Vec3 inward_of(const Vec3& tangent) const { return side_ * plane_normal_.cross(tangent); }

  Vec3 plane_normal_;
  double depth_m_;
  double side_;
  std::vector<Waypoint> waypoints_;
};

}  // namespace palpate
