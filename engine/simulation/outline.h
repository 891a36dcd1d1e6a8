#pragma once

// The curves in which a plane cuts a scene, reduced to the parts that a hand can reach.

#include <optional>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

struct Outline {
  Polyline curve;
  bool has_two_sides;  // true for a part of a sheet; a part of a closed curve has only a front
};

// The outlines of the union of the regions that the curves enclose, as free_chains() defines the
// union. Parts inside other solids are left out; where one curve enters the solid of another, the
// outline continues along the other curve. A curve that meets no other is unchanged. Two open ends,
// for example where parts do not quite meet, are joined if they are nearer to each other than
// small_m; the nearest pairs are joined first.
//
// The result is sorted, longest first, ties in the order of the curves. Returns no value if so many
// curves cross each other that planar_pieces() gives up. All curves lie in one plane. Allocates;
// the cost is that of free_chains().
std::optional<std::vector<Outline>> outlines(const std::vector<Polyline>& curves,
                                             const Vec3& plane_normal, double small_m);

}  // namespace palpate
