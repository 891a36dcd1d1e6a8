#pragma once

// An exact test whether a segment meets a triangle.

#include "geometry/base/types.h"
#include "geometry/exact/orientation.h"
#include "geometry/exact/triangle.h"

namespace palpate {

// Bound on the rounding error of a height, normal . (p - a), as computed here, relative to
// |p - a|_1. Three subtractions, three products and two sums give 6 roundings, and the unit normal
// has an error of 4 roundings; the bound is twice their sum because of second-order terms.
inline constexpr double kHeightRoundoff = 20 * kUnitRoundoff;

// The intersection of the closed segment from p to q with a closed triangle.
struct SegmentCrossing {
  enum class Kind : std::uint8_t {
    kMiss,     // no common point
    kThrough,  // enters the triangle from one side of its plane
    kEdgeOn,   // lies in the triangle's plane and enters across an edge
    kWithin    // starts on the triangle
  };
  Kind kind = Kind::kMiss;
  double fraction = 0.0;            // the first common point: a fraction of the segment, in [0, 1]
  double height_start = 0.0;        // height of p above the plane, along its normal, metres
  double height_end = 0.0;          // height of q above the plane
  int side = 0;                     // kThrough: 1 if p is in front of the triangle, -1 behind
  Vec3 edge_normal = Vec3::Zero();  // kEdgeOn: unit, in the plane, outwards at the crossed edge
  Vec3 edge_point = Vec3::Zero();   // kEdgeOn: a corner on the crossed edge
  SignWork signs;
};

// Intersects the closed segment p q with the closed triangle t. Any frame, metres. The function
// decides exactly whether they meet and from which side, for the plane through the three corners.
// Fraction, edge and heights are rounded. noexcept, no allocation.
SegmentCrossing cross_segment(const TriangleGeometry& t, const Vec3& p, const Vec3& q) noexcept;

}  // namespace palpate
