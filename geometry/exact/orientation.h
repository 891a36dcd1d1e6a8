#pragma once

// On which side of a plane a point lies: exact.

#include <cmath>

#include "geometry/base/types.h"

namespace palpate {

// How many signs double could not tell, by what told them.
struct SignWork {
  int by_pairs = 0;  // of doubles
  int by_expansions = 0;
};

// The sign of (q - p) . ((r - p) x (s - p)): -1, 0 or 1. Zero iff the four points lie in one plane.
// It says on which side of the triangle p q r the point s is (1: on the side its normal points
// to), and on which side the line p q passes the edge r s.
//
// Double arithmetic settles nearly every call, pairs of doubles nearly all of the rest, exact
// expansions what remains. 113-bit arithmetic in software takes longer and cannot settle all,
// CGAL's filtered kernel takes as long: the README has the table, predicate_benchmark.cpp makes it.
//
// Adds to `work` what it took. Any frame, any unit, as long as no product of three coordinate
// differences overflows and none of their last bits underflows: coordinates from 1e-80 to 1e100.
// noexcept, no allocation.
int orientation(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                SignWork& work) noexcept;
inline int orientation(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) noexcept {
  SignWork work;
  return orientation(p, q, r, s, work);
}

// The same without the first filter, for those who have evaluated it themselves.
int orientation_in_doubt(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                         SignWork& work) noexcept;

// Unit round-off of double.
inline constexpr double kUnitRoundoff = 0x1p-53;

// Bound on the rounding of a triple product u . (v x w) of coordinate differences, relative to
// |u|_1 |v|_1 |w|_1: 3 for the differences, 3 for the cross product, 3 for the dot product; the
// rest is slack for second-order terms.
inline constexpr double kTripleRoundoff = 12 * kUnitRoundoff;

inline double norm1(const Vec3& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

}  // namespace palpate
