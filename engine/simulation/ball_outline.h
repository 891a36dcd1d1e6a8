#pragma once

// The parts of the outlines of solids that a ball can touch.

#include <optional>
#include <vector>

#include "engine/simulation/outline.h"
#include "geometry/base/types.h"

namespace palpate {

// The curves that a ball touches as it rolls around the solids with its centre in the plane. They
// consist of the parts of the outlines within the ball's reach, and of arcs of the ball between
// these parts. An arc occurs where the ball bridges a gap that is too narrow for it, and where the
// ball lies in a corner. At each contact the ball's centre is radius_m in front of the outline,
// that is, on the right of the outline, seen from the tip of plane_normal. A ball that is too large
// to enter any free region touches nothing.
//
// Only the ball's circle in the plane matters: geometry above or below the plane does not obstruct
// the ball. Sheets obstruct it from both sides. All returned curves are closed, longest first;
// detail smaller than radius_m / 256 is left out. found: outlines of one plane, as outlines()
// returns them. Returns no value if planar_pieces() gives up. It gives up if too many parts of the
// outlines are nearer to other parts than twice the radius. Allocates; O(n log n).
std::optional<std::vector<Outline>> ball_outlines(const std::vector<Outline>& found,
                                                  const Vec3& plane_normal, double radius_m);

}  // namespace palpate
