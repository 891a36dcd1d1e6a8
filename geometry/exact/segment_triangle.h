#pragma once

// Whether a segment touches a triangle: exact.

#include "geometry/base/types.h"
#include "geometry/exact/orientation.h"
#include "geometry/exact/triangle.h"

namespace palpate {

// Bound on the rounding of a height normal . (p - a) as computed here, relative to |p - a|_1.
// Three subtractions, three products, two sums give 6 roundings; the unit normal itself is good to
// 4; doubled for the second-order terms.
inline constexpr double kHeightRoundoff = 20 * kUnitRoundoff;

// The result of crossing the closed segment from p to q with a closed triangle.
struct SegmentCrossing {
  enum class Kind : std::uint8_t {
    kMiss,     // apart
    kThrough,  // meets it, coming from one side of its plane
    kEdgeOn,   // runs in its plane and meets it at an edge from outside
    kWithin    // starts on it
  };
  Kind kind = Kind::kMiss;
  double fraction = 0.0;            // where they meet, in [0, 1]
  double height_start = 0.0;        // of p over the plane, along the triangle's normal, metres
  double height_end = 0.0;          // of q
  int side = 0;                     // kThrough: 1 if p is in front of the triangle, -1 behind
  Vec3 edge_normal = Vec3::Zero();  // kEdgeOn: unit, in the plane, out of the triangle at that edge
  Vec3 edge_point = Vec3::Zero();   // kEdgeOn: a corner on that edge
  SignWork signs;
};

// Any frame, metres. Whether they meet, and from which side, is decided exactly; fraction, edge and
// heights are rounded. The plane is that of the three corners. noexcept, no allocation.
SegmentCrossing cross_segment(const TriangleGeometry& t, const Vec3& p, const Vec3& q) noexcept;

}  // namespace palpate
