#pragma once

// How large the numbers were that a product of transforms was made of.

#include <cmath>
#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// At least the largest factor by which a matrix lengthens a vector; for scales and rotations, in
// this order, no more than that but for rounding. |L|^2 = |L^T L| <= its largest row sum.
inline double lengthening(const Mat3& linear) {
  const double largest = linear.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return largest;
  const Mat3 scaled = linear / largest;  // whose squares neither overflow nor vanish
  return largest * std::sqrt((scaled.transpose() * scaled).cwiseAbs().rowwise().sum().maxCoeff());
}

// The length of a vector whose squares may overflow or vanish.
inline double length_of(const Vec3& vector) {
  constexpr double kSquaresAreNormal = 1e150;
  const double length = vector.norm();
  return length < kSquaresAreNormal && length > 1.0 / kSquaresAreNormal ? length
                                                                        : vector.stableNorm();
}

// What a bound on the rounding of a product of transforms p -> linear p + translation_m goes by. A
// long way out and back leaves a short one with the rounding of the long one.
struct TransformProduct {
  std::uint32_t factors = 0;
  double linear = 1.0;          // the product of the factors' lengthening()
  Vec3 columns = Vec3::Ones();  // lengths of the last factor's columns, as lengthened by the others
  double translation_m = 0.0;   // the sum of the translations' lengths, each as lengthened

  static TransformProduct of(const Mat3& linear, const Vec3& translation_m) {
    // Spares most nodes a decomposition.
    if (linear == Mat3::Identity()) return {1, 1.0, Vec3::Ones(), length_of(translation_m)};
    const Vec3 columns(length_of(linear.col(0)), length_of(linear.col(1)),
                       length_of(linear.col(2)));
    return {1, lengthening(linear), columns, length_of(translation_m)};
  }
  // First inner, then this.
  TransformProduct operator*(const TransformProduct& inner) const {
    return {factors + inner.factors, linear * inner.linear, linear * inner.columns,
            linear * inner.translation_m + translation_m};
  }
};

}  // namespace palpate
