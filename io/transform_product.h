#pragma once

// The magnitudes of the factors in a product of transforms, for bounds on its rounding error.

#include <cmath>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// An upper bound on the largest factor by which a matrix lengthens a vector. For a product of a
// scale and a rotation the bound is exact up to rounding. |L|^2 = |L^T L| <= the largest row sum of
// |L^T L|.
inline double lengthening(const Mat3& linear) {
  const double largest = linear.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return largest;
  const Mat3 scaled = linear / largest;  // its squares neither overflow nor underflow
  return largest * std::sqrt((scaled.transpose() * scaled).cwiseAbs().rowwise().sum().maxCoeff());
}

// The length of a vector whose squares may overflow or underflow.
inline double length_of(const Vec3& vector) {
  constexpr double kSquaresAreNormal = 1e150;
  const double length = vector.norm();
  return length < kSquaresAreNormal && length > 1.0 / kSquaresAreNormal ? length
                                                                        : vector.stableNorm();
}

// The magnitudes that bound the rounding error of a product of transforms p -> linear p +
// translation_m. If two long translations cancel, the short translation that remains has the
// rounding error of the long ones.
struct TransformProduct {
  std::uint32_t factors = 0;
  double linear = 1.0;          // the product of the factors' lengthening()
  Vec3 columns = Vec3::Ones();  // column lengths of the last factor, times the others' lengthening
  // Sum of the lengths of the translations, each times the lengthening of the factors to its left.
  double translation_m = 0.0;

  static TransformProduct of(const Mat3& linear, const Vec3& translation_m) {
    // The common case needs no further computation.
    if (linear == Mat3::Identity()) return {1, 1.0, Vec3::Ones(), length_of(translation_m)};
    const Vec3 columns(length_of(linear.col(0)), length_of(linear.col(1)),
                       length_of(linear.col(2)));
    return {1, lengthening(linear), columns, length_of(translation_m)};
  }
  // The transform inner, followed by this one.
  TransformProduct operator*(const TransformProduct& inner) const {
    return {factors + inner.factors, linear * inner.linear, linear * inner.columns,
            linear * inner.translation_m + translation_m};
  }
};

}  // namespace palpate
