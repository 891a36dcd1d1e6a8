#pragma once

// The curves in which a plane cuts a triangle surface.

#include <vector>

#include "geometry/base/types.h"

namespace palpate {

struct Polyline {
  // In the frame of the surface. A closed polyline does not repeat its first point.
  std::vector<Vec3> points_m;
  bool closed = false;
};

// The sum of the segment lengths, including the closing segment. Requires at least one point in a
// closed polyline.
double length_m(const Polyline& polyline);

// Cuts triangles with the plane plane_normal . x = plane_offset_m.
//
// positions: finite, metres, welded, for example SurfaceMesh::welded_positions() with faces().
// Welding is required because segments are chained through shared edges, which are identified by
// vertex indices. plane_normal: unit, same frame. A vertex in the plane always counts as above the
// plane. A closed surface therefore gives closed curves in every position, and a face in the plane
// gives no curve.
//
// Seen from the tip of plane_normal, each curve has the back side of its faces on its left; for a
// solid, this is the side of the material. Where more than two faces meet at an edge, curves are
// joined so that separate regions of material stay separate. A curve is open if it ends at edges
// without a neighbouring face or with a neighbour of opposite orientation. Points are removed if
// they are within rounding (32 half-ulps of the largest coordinate) of the segment that replaces
// them. Curves shorter than this rounding are removed, too. The longest curve is first; ties are in
// order of triangles.
//
// Allocates; O(positions + triangles), and O(n log n) in the number of cut triangles. Safe on any
// thread.
std::vector<Polyline> plane_section(const std::vector<Vec3>& positions_m,
                                    const std::vector<Triangle>& triangles,
                                    const Vec3& plane_normal, double plane_offset_m);

}  // namespace palpate
