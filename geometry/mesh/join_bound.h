#pragma once

// Bounds on the distance of two positions that a program wrote to a file for one point.

#include <limits>

#include "geometry/base/types.h"

namespace palpate {

// Distance between 1 and the next float: relative to a coordinate, the largest unit in the last
// place of a float.
inline constexpr double kFloatEpsilon = std::numeric_limits<float>::epsilon();

// Of each of the two positions: half a unit to store it, half a unit for the operation before, such
// as the translation of the mesh. Relative to the coordinate, by axis.
inline constexpr double kStoredRounding = 2 * kFloatEpsilon;

// A generator that turns a profile about an axis computes the last column at an angle of 2 pi more
// than the first column, in single precision. In units of the radius times kFloatEpsilon: 1.5 for
// 2 pi, which a float represents with an error of 1.75e-7; 4 for the sum of 2 pi and an angle of
// the first column of up to 2 pi, half a unit of numbers from 8 to 16; 1 for the sine or cosine;
// 0.5 for its product with the radius. The same bounds the radius of a pole, sin(pi) instead of 0.
// The radius is at most half of the extent of the surface that is turned.
inline constexpr double kSineRounding = 0.5 * (1.5 + 4 + 1 + 0.5) * kFloatEpsilon;

// The bound, by axis, on the distance of two positions, in the frame of a mesh. extent_m: the
// largest extent of the surface, the smaller one if the positions are of two surfaces that share no
// vertex.
inline Vec3 join_bound_m(const Vec3& p, const Vec3& q, double extent_m) {
  const Vec3 far_m = p.cwiseAbs().cwiseMax(q.cwiseAbs());
  return (kStoredRounding * far_m).array() + kSineRounding * extent_m;
}

inline bool is_within(const Vec3& p, const Vec3& q, const Vec3& bound_m) {
  return ((p - q).cwiseAbs().array() <= bound_m.array()).all();
}

}  // namespace palpate
