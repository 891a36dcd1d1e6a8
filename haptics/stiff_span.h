#pragma once

// The directions in which a contact is stiff, from the changes of its force.

#include <cmath>

#include "geometry/base/types.h"

namespace palpate {

// On a device whose encoders have steps, the force changes in jumps, each along the axis whose
// encoder has stepped, and between them not at all: a single change does not say along which line
// the force moves. The span sums d d^T over the last changes d of the force, as S = sum (1 -
// kForget)^n d d^T. The part of a vector v in the span is S v tr(S) / |S|^2, at most as long as v.
// On a wall it is the part along the normal, exactly; in a groove, where the force changes as much
// along both axes, it is v. Its product with v is never negative.
//
// One thread owns an object. No function allocates or throws.
class StiffSpan {
 public:
  // Half of a swing of two steps has about eight changes.
  static constexpr double kForget = 1.0 / 8.0;

  void add(const Vec3& change_N) noexcept {
    if (change_N.isZero(0.0)) return;
    sum_N2_ *= 1.0 - kForget;
    sum_N2_ += change_N * change_N.transpose();
    const double square = sum_N2_.squaredNorm();
    per_N2_ = square > 0.0 ? sum_N2_.trace() / square : 0.0;
  }
  Vec3 part(const Vec3& v) const noexcept {
    const Vec3 part = per_N2_ * (sum_N2_ * v);
    const double part2 = part.squaredNorm();
    const double most2 = v.squaredNorm();
    // Uneven changes would make it longer, by up to 1.37.
    return part2 > most2 ? Vec3(std::sqrt(most2 / part2) * part) : part;
  }
  void clear() noexcept { *this = {}; }

 private:
  Mat3 sum_N2_ = Mat3::Zero();
  double per_N2_ = 0.0;
};

}  // namespace palpate
