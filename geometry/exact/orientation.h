#pragma once

// An exact orientation predicate: the side of a plane on which a point lies.

#include <cmath>

#include "geometry/base/types.h"

namespace palpate {

// Counts of the signs that double arithmetic left undecided, one count for each arithmetic that
// decided them.
struct SignWork {
  int by_pairs = 0;  // pairs of doubles
  int by_zeros = 0;  // the same: 0, since each product of three differences has a factor 0
  int by_expansions = 0;
};

// The sign of (q - p) . ((r - p) x (s - p)): -1, 0 or 1. Zero iff the four points lie in one plane.
// The sign is the side of the triangle p q r on which the point s lies (1: the side that the
// triangle's normal points to). It is also the side on which the line p q passes the edge r s.
//
// Double arithmetic decides nearly every call, pairs of doubles decide nearly all remaining calls,
// and exact expansions decide the rest. Pairs of doubles also decide a 0 whose every product is 0:
// that of points in one coordinate plane, which are frequent where boxes meet. Two alternatives are
// no better. 113-bit arithmetic in software is slower and leaves some signs undecided. CGAL's
// filtered kernel changes the rounding mode and is faster than exact expansions in one class of
// inputs only. predicate_benchmark.cpp measures the times; docs/study/results-loading.md has them.
//
// Counts in `work` which arithmetic decided the sign. Any frame, any unit. Requires that no product
// of three coordinate differences overflows and that none of its last bits underflows, which holds
// for coordinates from 1e-80 to 1e100. noexcept, no allocation.
int orientation(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                SignWork& work) noexcept;
inline int orientation(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) noexcept {
  SignWork work;
  return orientation(p, q, r, s, work);
}

// Like orientation(), but without the first filter, for callers that have already evaluated this
// filter.
int orientation_in_doubt(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                         SignWork& work) noexcept;

// Unit round-off of double.
inline constexpr double kUnitRoundoff = 0x1p-53;

// Bound on the rounding of a triple product u . (v x w) of coordinate differences, relative to
// |u|_1 |v|_1 |w|_1. The 12 round-offs include 3 for the differences, 3 for the cross product and 3
// for the dot product; the rest is slack for second-order terms.
inline constexpr double kTripleRoundoff = 12 * kUnitRoundoff;

inline double norm1(const Vec3& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

}  // namespace palpate
