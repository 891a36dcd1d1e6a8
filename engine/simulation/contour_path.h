#pragma once

// Converts a contour to a path that a hand can follow.

#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

// Opens a closed contour in the middle of a segment; the contour then begins and ends there. The
// segment is the longest one with enough clearance in front of its middle, that is, on the right of
// the contour, seen from the tip of plane_normal. curves: all curves in which the plane cuts the
// scene, including the contour. room_m: the wanted clearance; it is set to half of the available
// clearance if this half is smaller. An open contour keeps its points.
std::vector<Vec3> open_contour(const Polyline& contour, const std::vector<Polyline>& curves,
                               const Vec3& plane_normal, double& room_m);

// The path of a hand that presses on the contour from its right, seen from the tip of plane_normal.
// Points within tolerance_m of the legs that replace them are left out. contour_m: two or more
// points in one plane.
HandPath contour_path(const std::vector<Vec3>& contour_m, const Vec3& plane_normal,
                      double tolerance_m);

}  // namespace palpate
