#pragma once

// Leaves out the points of a plane curve that lie on the segment between their neighbours.

#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// The points of a curve in a plane of unit normal plane_normal, without those that are within
// tolerance_m of the segment that replaces them and without turning back. All that is left out at
// one segment is checked against that segment, so deviations do not add up along a finely divided
// arc. The ends of an open curve stay; a closed one (first point not repeated) may start elsewhere.
// Fewer than two points are left iff all are within tolerance_m of the first. Linear time.
std::vector<Vec3> without_collinear_points(std::vector<Vec3> points_m, bool closed,
                                           const Vec3& plane_normal, double tolerance_m);

}  // namespace palpate
