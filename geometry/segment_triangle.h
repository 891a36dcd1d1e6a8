#pragma once

// Whether a segment touches a triangle: a filtered test that never says "miss" wrongly.

#include "geometry/triangle.h"
#include "geometry/types.h"

namespace palpate {

// Unit round-off of double.
inline constexpr double kUnitRoundoff = 0x1p-53;

// Bound on the rounding of a height normal . (p - a) as computed here, relative to |p - a|_1 (and
// |d|_1 where d is added). Three subtractions, three products, two sums give 6 roundings; the unit
// normal itself is good to 4; doubled for the second-order terms.
inline constexpr double kHeightRoundoff = 20 * kUnitRoundoff;

// Bound on the rounding of a triple product u . (v x w) of coordinate differences, relative to
// |u|_1 |v|_1 |w|_1: 3 for the differences, 3 for the cross product, 3 for the dot product; the
// rest is slack for second-order terms.
inline constexpr double kTripleRoundoff = 12 * kUnitRoundoff;

// The result of crossing the closed segment p to p + d with a closed triangle.
struct SegmentCrossing {
  enum class Kind : std::uint8_t {
    kMiss,     // certainly apart
    kThrough,  // meets it, or cannot be told apart from meeting it, changing sides
    kEdgeOn    // runs in its plane and meets it at an edge from outside
  };
  Kind kind = Kind::kMiss;
  double fraction = 0.0;            // where they meet, in [0, 1]
  double height_start = 0.0;        // of p over the plane, along the triangle's normal, metres
  double height_end = 0.0;          // of p + d
  Vec3 edge_normal = Vec3::Zero();  // kEdgeOn: unit, in the plane, out of the triangle at that edge
  Vec3 edge_point = Vec3::Zero();   // kEdgeOn: a corner on that edge
};

// Any frame, metres. "In doubt" counts as meeting: signs that double precision cannot certify are
// taken again in 113 bits before they do. No absolute tolerance. noexcept, no allocation.
SegmentCrossing cross_segment(const TriangleGeometry& t, const Vec3& p, const Vec3& d) noexcept;

}  // namespace palpate
