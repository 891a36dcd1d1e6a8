#pragma once

// Segments of a plane, cut into pieces that meet at their ends only.

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "geometry/mesh/planar_boxes.h"

namespace palpate {

struct PlanarSegment {
  Eigen::Vector2d from, to;
};

// A vertex, and where it comes from: so much of the way along a segment, 0 and 1 being its ends.
struct PlanarVertex {
  GridPoint at;
  std::uint32_t segment;
  double share;
};

// From vertex to vertex, in the direction of the segment that it is a part of.
struct PlanarPiece {
  std::uint32_t from, to;
  std::uint32_t segment;
};

struct PlanarPieces {
  std::vector<PlanarVertex> vertices;
  std::vector<PlanarPiece> pieces;  // by segment, along it
  double merged_m = 0.0;            // what is nearer than this is one
  bool gave_up = false;  // so many segments are near to each other that not all were looked at
};

// Vertices lie on a grid, so that what is asked of them has an exact answer, and more than merged_m
// apart. Where segments cross, touch or lie on one another within half of merged_m they have
// vertices in common; pieces that coincide have both. A segment that closes a chain still does so.
//
// merged_m is 2^-20 of the extent, some sixteen times what coordinates in single precision are
// rounded by: what coincides in a model does so to its rounding. It is more where largest_m, the
// largest coordinate that the segments were computed from, has been rounded by more.
//
// Deterministic. O(n log n); gives up where boxes around the segments overlap more than ten million
// others and 32 a segment, or where they cross in more than a million places and 32 a segment.
PlanarPieces planar_pieces(const std::vector<PlanarSegment>& segments, double largest_m);

}  // namespace palpate
