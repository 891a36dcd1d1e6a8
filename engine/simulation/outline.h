#pragma once

// Of the curves in which a plane cuts a scene, what a hand can get at.

#include <optional>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

struct Outline {
  Polyline curve;
  bool has_two_sides;  // part of a sheet; what was cut out of a closed curve has a front alone
};

// The outlines of the union of all that the curves go round, as free_chains() defines it: what lies
// inside other solids is left out, and where one curve enters another the outline goes on along
// that one. A curve that meets no other stays as it is. Ends that are left open, as where parts do
// not quite meet, are joined if they are nearer than small_m, the nearest first.
//
// Longest first, ties in the order of the curves. Nothing where so many curves cross each other
// that planar_pieces() gives up. All curves in one plane. Allocates; takes what free_chains()
// takes.
std::optional<std::vector<Outline>> outlines(const std::vector<Polyline>& curves,
                                             const Vec3& plane_normal, double small_m);

}  // namespace palpate
