#pragma once

// Of the outlines of solids, what a ball can touch.

#include <optional>
#include <vector>

#include "engine/simulation/outline.h"
#include "geometry/base/types.h"

namespace palpate {

// What touches a ball that rolls around the solids with its centre in the plane: the parts of the
// outlines that it gets at, and between them the arcs of the ball that bridges a gap it does not
// get into, or lies in a corner. Where it touches one of them, its centre is radius_m in front: on
// the right, seen from the tip of plane_normal. A ball so large that it gets nowhere touches
// nothing.
//
// Of the ball this takes its circle in the plane: what is above or below the plane does not hold it
// off. Sheets hold it off from both sides. All are closed, longest first; what is of less than
// radius_m / 256 is left out. found: of one plane, as of outlines(). Nothing where so many places
// have others within twice the radius that planar_pieces() gives up. Allocates; O(n log n).
std::optional<std::vector<Outline>> ball_outlines(const std::vector<Outline>& found,
                                                  const Vec3& plane_normal, double radius_m);

}  // namespace palpate
