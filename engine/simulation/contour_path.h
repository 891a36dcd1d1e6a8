#pragma once

// A contour as a hand follows it.

#include <vector>

#include "engine/simulation/hand_path.h"
#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

// Opens a closed contour, so that it begins and ends in the middle of a segment: of the longest
// from whose middle nothing is near in front. curves: all that the plane cuts, the contour
// included. room_m: how much room there is to be; set to half of what there is where there is less.
// In front: on the right of the contour, seen from the tip of plane_normal. An open contour stays
// as it is.
std::vector<Vec3> open_contour(const Polyline& contour, const std::vector<Polyline>& curves,
                               const Vec3& plane_normal, double& room_m);

// Pressed on from the right, seen from the tip of plane_normal. Leaves out what is within
// tolerance_m of the legs that stand for it. contour_m: of one plane; two points or more.
HandPath contour_path(const std::vector<Vec3>& contour_m, const Vec3& plane_normal,
                      double tolerance_m);

}  // namespace palpate
