#pragma once

// The outlines of the regions that curves in a plane enclose. An outline is a chain of pieces of
// these curves.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

// A piece of a curve, from this point to the next point of the chain.
struct ChainPoint {
  Vec3 p_m;
  std::uint32_t curve, segment;  // the curve and the segment that contain the piece
  bool is_junction;              // several curves meet at this point
};

struct FreeChain {
  // In an open chain, the last point names the chain's last segment.
  std::vector<ChainPoint> points;
  bool closed;
  bool has_two_sides;  // all its pieces belong to open curves
  bool is_sheet;       // its first piece has no solid behind it
};

struct FreeChains {
  std::vector<FreeChain> chains;
  double merged_m;  // points at most this far apart are merged, see planar_pieces()
  bool gave_up;     // planar_pieces() gave up, and chains is empty
};

// A point of the plane is in the solid region if the sum of the winding numbers of all curves about
// it is positive. For this sum, a straight segment closes each open curve, and negative winding
// numbers of open curves do not count. Material is on the left of a curve, seen from the tip of
// plane_normal; the rest of the plane is free.
//
// A piece of a curve belongs to a chain if the region in front of it is free. If pieces coincide,
// one of them represents all. Where solids touch, no free region lies between them. Where several
// pieces meet, chains turn so that the free region on their right stays connected: a point that
// follows a chain never passes between two touching solids. A sheet that meets solids, so that only
// one of its sides is a front, forms separate chains.
//
// The chains are in the order of the curves. All curves must lie in one plane. Allocates; O(n log
// n) for n segments if each segment meets few others and no axis-parallel line crosses many of
// them. Deterministic.
FreeChains free_chains(const std::vector<Polyline>& curves, const Vec3& plane_normal);

}  // namespace palpate
