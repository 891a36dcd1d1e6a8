#pragma once

// The outlines of the regions that curves in a plane enclose, as chains of pieces of these curves.

#include <cstdint>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/section.h"

namespace palpate {

// A piece of a curve, from this point to the next point of the chain.
struct ChainPoint {
  Vec3 p_m;
  std::uint32_t curve, segment;  // of which the piece is a part
  bool is_junction;              // curves meet here
};

struct FreeChain {
  std::vector<ChainPoint> points;  // open: the last one names the segment that ends there
  bool closed;
  bool has_two_sides;  // all its pieces belong to open curves
  bool is_sheet;       // its first piece has no solid behind it
};

struct FreeChains {
  std::vector<FreeChain> chains;
  double merged_m;  // points nearer than this are merged, see planar_pieces()
  bool gave_up;     // planar_pieces() gave up; chains is empty then
};

// The solid region is the union of the regions that closed curves enclose, by the sum of their
// winding numbers, and the regions that open curves enclose when a straight segment closes them.
// Material is on the left of a curve, seen from the tip of plane_normal; the rest of the plane is
// free.
//
// A piece of a curve belongs to a chain if the region in front of it is free. If pieces coincide,
// one represents all of them; where solids touch, no free region lies between them. Where several
// pieces meet, chains turn so that the free region on their right stays connected: a point that
// follows a chain never passes between two touching solids. A sheet that meets solids, so that only
// one of its sides is a front, forms chains of its own.
//
// The chains are in the order of the curves. All curves must lie in one plane. Allocates; O(n log
// n) for n segments if each meets few others and no axis-parallel line crosses many of them.
// Deterministic.
FreeChains free_chains(const std::vector<Polyline>& curves, const Vec3& plane_normal);

}  // namespace palpate
