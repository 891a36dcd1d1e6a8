#include "geometry/exact/orientation.h"

#include <array>
#include <cmath>
#include <optional>

#include "geometry/exact/expansion.h"

namespace palpate {
namespace {

using Difference = std::array<TwoTerms, 3>;

Difference difference(const Vec3& a, const Vec3& b) {
  return {two_difference(a.x(), b.x()), two_difference(a.y(), b.y()), two_difference(a.z(), b.z())};
}

// Arithmetic on pairs of doubles, with the relative error of each result in units of e^2, e = 2^-53
// (M. Joldes, J.-M. Muller and V. Popescu, "Tight and Rigorous Error Bounds for Basic Building
// Blocks of Double-Word Arithmetic", 2017).
TwoTerms add(const TwoTerms& a, const TwoTerms& b) {  // 3, up to higher orders
  const TwoTerms high = two_sum(a.high, b.high);
  const TwoTerms low = two_sum(a.low, b.low);
  const TwoTerms sum = ordered_sum(high.high, high.low + low.high);
  return ordered_sum(sum.high, low.low + sum.low);
}
TwoTerms multiply(const TwoTerms& a, const TwoTerms& b) {  // 6
  const TwoTerms product = two_product(a.high, b.high);
  return ordered_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

// The sign of u . (v x w) by pairs of doubles, or nullopt if it is undecided.
std::optional<int> paired_sign(const Difference& u, const Difference& v, const Difference& w) {
  TwoTerms volume{0.0, 0.0};
  double magnitude = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const TwoTerms left = multiply(v[j], w[k]);
    const TwoTerms right = multiply(v[k], w[j]);
    volume = add(volume, multiply(add(left, negated(right)), u[i]));
    magnitude += (std::abs(left.high) + std::abs(right.high)) * std::abs(u[i].high);
  }
  // Two products have 6 each, a difference 3 and two sums 3 each: 21 e^2 of the magnitude. The rest
  // of the bound covers higher orders and the rounding of the magnitude.
  const double bound = 40.0 * 0x1p-106 * magnitude;
  if (volume.high > bound) return 1;
  if (volume.high < -bound) return -1;
  // A difference whose high part is 0 is 0, and no product underflows.
  return magnitude == 0.0 ? std::optional(0) : std::nullopt;
}

int exact_sign(const Difference& u, const Difference& v, const Difference& w) {
  const auto part = [&](std::size_t i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    return product(sum(product(expansion(v[j]), w[k]), product(expansion(negated(v[k])), w[j])),
                   u[i]);
  };
  return sum(sum(part(0), part(1)), part(2)).sign();
}

}  // namespace

int orientation_in_doubt(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                         SignWork& work) noexcept {
  const Difference u = difference(q, p);
  const Difference v = difference(r, p);
  const Difference w = difference(s, p);
  if (const std::optional<int> sign = paired_sign(u, v, w)) {
    ++(*sign == 0 ? work.by_zeros : work.by_pairs);
    return *sign;
  }
  ++work.by_expansions;
  return exact_sign(u, v, w);
}

int orientation(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s,
                SignWork& work) noexcept {
  const Vec3 u = q - p;
  const Vec3 v = r - p;
  const Vec3 w = s - p;
  const double volume = triple_product(u, v, w);
  const double bound = kTripleRoundoff * norm1(u) * norm1(v) * norm1(w);
  if (volume > bound) return 1;
  if (volume < -bound) return -1;
  return orientation_in_doubt(p, q, r, s, work);
}

}  // namespace palpate
