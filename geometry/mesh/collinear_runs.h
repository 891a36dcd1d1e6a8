#pragma once

// Removes the points of a plane curve that lie on the segment between their neighbours.

#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// Replaces runs of points by segments, for a curve in a plane with unit normal plane_normal. All
// points of a run lie within tolerance_m of the segment that replaces them, and the run never turns
// back. Every removed point is checked against its segment, so that deviations do not add up along
// a finely divided arc. The ends of an open curve are kept; a closed curve (first point not
// repeated) may start at another point. The result has fewer than two points iff all points are
// within tolerance_m of the first. Linear time.
std::vector<Vec3> without_collinear_points(std::vector<Vec3> points_m, bool closed,
                                           const Vec3& plane_normal, double tolerance_m);

}  // namespace palpate
