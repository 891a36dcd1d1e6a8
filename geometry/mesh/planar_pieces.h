#pragma once

// Cuts segments in a plane into pieces that meet only at their ends.

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "geometry/mesh/planar_boxes.h"

namespace palpate {

struct PlanarSegment {
  Eigen::Vector2d from, to;
};

// A vertex and its origin: a segment, and the position on it as a fraction of its length, from 0 to
// 1.
struct PlanarVertex {
  GridPoint at;
  std::uint32_t segment;
  double share;
};

// A part of a segment between two vertices, in the direction of the segment.
struct PlanarPiece {
  std::uint32_t from, to;
  std::uint32_t segment;
};

struct PlanarPieces {
  std::vector<PlanarVertex> vertices;
  std::vector<PlanarPiece> pieces;  // sorted by segment, and along each segment
  double merged_m = 0.0;            // points within this distance are merged
  bool gave_up = false;  // too many segments are close together: not all pairs were examined
};

// Vertices lie on a grid, so that geometric predicates on them are exact. Any two vertices are more
// than merged_m apart. Segments that cross, touch or overlap within half of merged_m share
// vertices; pieces that coincide share both vertices. A closed chain of segments stays closed.
//
// merged_m is 2^-20 of the largest extent of the segments. This is about sixteen times the rounding
// of coordinates in single precision; parts of a model coincide only up to this rounding. merged_m
// is larger if the rounding of largest_m requires it. largest_m: the largest coordinate from which
// the segments were computed.
//
// Deterministic. O(n log n) for n segments. The function gives up if more than ten million + 32 n
// pairs of bounding boxes overlap, or if more than one million + 32 n vertices arise.
PlanarPieces planar_pieces(const std::vector<PlanarSegment>& segments, double largest_m);

}  // namespace palpate
