#pragma once

// Of the curves in which a plane cuts a scene, what a hand can get at.

#include <vector>

#include "geometry/section.h"
#include "geometry/types.h"

namespace palpate {

struct Outline {
  Polyline curve;
  bool has_two_sides;  // part of a sheet; what was cut out of a closed curve has a front alone
};

// What lies inside other solids is no outline: it is left out, and where one curve enters another
// the outline goes on along that one, as that of their union. Solid is what the curves go round, by
// their winding number, open ones straight back to where they begin; material is on the left seen
// from the tip of plane_normal. A curve of which nothing is hidden stays as it is. Ends nearer than
// small_m are joined, and what is hidden or free for less than that may be overlooked.
//
// Longest first. All curves in one plane. Allocates; O(n) places for n times small_m of length, at
// most kMostPlaces, each in the segments of the curves around it.
std::vector<Outline> outlines(const std::vector<Polyline>& curves, const Vec3& plane_normal,
                              double small_m);

}  // namespace palpate
