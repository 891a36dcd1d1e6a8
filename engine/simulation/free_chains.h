#pragma once

// The outlines of what curves in a plane go round, as chains of pieces of the curves.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

// A piece of a curve: from its point on to that of the next.
struct ChainPoint {
  Vec3 p_m;
  std::uint32_t curve, segment;  // which it is a part of
  bool is_junction;              // curves meet here
};

struct FreeChain {
  std::vector<ChainPoint> points;  // open: the last one names the segment that ends there
  bool closed;
  bool has_two_sides;  // of open curves alone
  bool is_sheet;       // begins with nothing solid behind it
};

struct FreeChains {
  std::vector<FreeChain> chains;
  double merged_m;  // what is nearer than this is one, see planar_pieces()
  bool gave_up;     // planar_pieces() did; there are no chains then
};

// Solid is what a closed curve goes round, by the winding numbers of all of them together, and what
// an open one has behind it, if it is closed straight. Material is on the left of a curve, seen
// from the tip of plane_normal; the rest of the plane is free.
//
// A piece of a curve is in a chain if what is in front of it is free. Of pieces that coincide one
// stands for all; where solids touch, nothing is free between them. At a place that several pieces
// go through, chains turn so that what is free on their right stays in one: a point that follows
// them never has to pass between two solids that touch there. Sheets that solids meet, of which
// only one side is a front, are chains of their own.
//
// In the order of the curves. All of one plane. Allocates; O(n log n) for n segments that meet few
// others and no line sees many of. Deterministic.
FreeChains free_chains(const std::vector<Polyline>& curves, const Vec3& plane_normal);

}  // namespace palpate
