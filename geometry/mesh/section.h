#pragma once

// The curves in which a plane cuts a triangle surface.

#include <vector>

#include "geometry/base/types.h"

namespace palpate {

struct Polyline {
  std::vector<Vec3>
      points_m;  // in the frame of the surface; a closed one does not repeat the first
  bool closed = false;
};

// Sum of the segments, the closing one included. A closed polyline has a point at least.
double length_m(const Polyline& polyline);

// Cuts triangles by the plane plane_normal . x = plane_offset_m.
//
// positions: finite, metres, welded (SurfaceMesh::welded_positions() and faces(), say), because
// segments are chained through shared edges, known by their vertex indices. plane_normal: unit,
// same frame. A vertex in the plane counts as above it, everywhere alike, so that a closed surface
// gives closed curves however it meets the plane, and a face that lies in the plane gives nothing.
//
// Seen from the tip of plane_normal each curve keeps the back of its faces, a solid's material, on
// its left. Where several faces meet at an edge, curves go on so that material stays apart; where
// neighbours are oriented against each other or there is none, the curve is open and ends. Points
// within rounding of the segment that replaces them (32 half-ulps of the largest coordinate) are
// left out, and curves shorter than that. Longest first, ties in order of triangles.
//
// Allocates; O(positions + triangles), and O(n log n) in those cut. Safe on any thread.
std::vector<Polyline> plane_section(const std::vector<Vec3>& positions_m,
                                    const std::vector<Triangle>& triangles,
                                    const Vec3& plane_normal, double plane_offset_m);

}  // namespace palpate
