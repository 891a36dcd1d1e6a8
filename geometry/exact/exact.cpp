#include "geometry/exact/exact.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/exact/expansion.h"

// On x86-64, std::fma is a library call, except in functions compiled for processors with FMA and
// in code inlined there, where it is one instruction.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define PALPATE_HAS_FMA_TARGET 1
#define PALPATE_INLINE [[gnu::always_inline]] inline
#else
#define PALPATE_HAS_FMA_TARGET 0
#define PALPATE_INLINE inline
#endif

namespace palpate {
namespace {

constexpr double kHalfUlpOfOne = 0x1p-53;
constexpr int kMantissaBits = 52;
constexpr int kBias = 1023;

// The component of (b - a) x (c - a) along the axis that completes axes i and j, for corners from
// scaled_corners(). The relative error is at most two ulp, and the result is zero iff the exact
// component is zero.
PALPATE_INLINE double cross_component(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  const TwoTerms b_i = two_difference(b[i], a[i]);
  const TwoTerms b_j = two_difference(b[j], a[j]);
  const TwoTerms c_i = two_difference(c[i], a[i]);
  const TwoTerms c_j = two_difference(c[j], a[j]);
  const TwoTerms left = two_product(b_i.high, c_j.high);
  const TwoTerms right = two_product(b_j.high, c_i.high);
  const double mixed =
      (b_i.high * c_j.low + b_i.low * c_j.high) - (b_j.high * c_i.low + b_j.low * c_i.high);
  const double value = (left.high - right.high) + (mixed + (left.low - right.low));

  // With e half an ulp of 1 and m the size below, the rounding errors are 6 e^2 m in `mixed`, e^2 m
  // in the low terms and 3 e^2 m in their sum. The omitted products of two low terms are at most
  // e^2 m. The total is less than e |value| if m <= |value| / (16 e). The difference of the high
  // terms is exact if they nearly cancel, and otherwise has an error of at most e |value|, as does
  // the last sum.
  const double size = std::abs(left.high) + std::abs(right.high);
  if (16.0 * kHalfUlpOfOne * size <= std::abs(value)) return value;

  return sum(product(expansion(b_i), c_j), product(expansion(negated(b_j)), c_i)).rounded();
}

// True if this component is certainly not zero, computed from the unscaled corners.
bool component_certainly_nonzero(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  const double left = (b[i] - a[i]) * (c[j] - a[j]);
  const double right = (b[j] - a[j]) * (c[i] - a[i]);
  // Three roundings of at most half an ulp of either product; the last term covers underflow.
  // An overflow makes the comparison false.
  const double rounding = 4.0 * kHalfUlpOfOne * (std::abs(left) + std::abs(right));
  return std::abs(left - right) > rounding + std::numeric_limits<double>::min();
}

// Like std::ilogb(), but without a library call for normal numbers.
PALPATE_INLINE int exponent_of(double magnitude) {
  if (!(magnitude >= std::numeric_limits<double>::min())) return std::ilogb(magnitude);
  return static_cast<int>(std::bit_cast<std::uint64_t>(magnitude) >> kMantissaBits) - kBias;
}

// 2^exponent, for the exponent of a normal double. Like std::ldexp(1.0, exponent), but without a
// library call.
PALPATE_INLINE double power_of_two(int exponent) {
  assert(-kBias < exponent && exponent <= kBias);
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + kBias) << kMantissaBits);
}

struct Corners {
  Vec3 a, b, c;
};

// The corners times a power of two that scales the largest coordinate to about 2^500. Squares of
// coordinates are then far from overflow, and products of their last bits do not underflow.
PALPATE_INLINE Corners scaled_corners(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double largest =
      std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
  if (largest == 0.0) return {a, b, c};
  // The scale is limited to the range of a double: corners scaled by less have no lower bits.
  const double scale = power_of_two(std::min(500 - exponent_of(largest), 1023));
  return {a * scale, b * scale, c * scale};
}

// (b - a) x (c - a), times a power of two.
PALPATE_INLINE Vec3 scaled_cross(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Corners s = scaled_corners(a, b, c);
  return {cross_component(s.a, s.b, s.c, 1, 2), cross_component(s.a, s.b, s.c, 2, 0),
          cross_component(s.a, s.b, s.c, 0, 1)};
}

PALPATE_INLINE Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 cross = scaled_cross(a, b, c);
  const double largest = cross.cwiseAbs().maxCoeff();
  assert(largest > 0.0);
  // In two steps: the power of two may be out of a double's range, but its square root is not.
  const int exponent = exponent_of(largest);
  const Vec3 near_one =
      (cross * power_of_two(-exponent / 2)) * power_of_two(exponent / 2 - exponent);
  return near_one / near_one.norm();
}

Vec3 unit_normal_baseline(const Vec3& a, const Vec3& b, const Vec3& c) {
  return unit_normal(a, b, c);
}

#if PALPATE_HAS_FMA_TARGET
// Identical results: both variants split products exactly.
[[gnu::target("fma")]] Vec3 unit_normal_fma(const Vec3& a, const Vec3& b, const Vec3& c) {
  return unit_normal(a, b, c);
}
#endif

using UnitNormal = Vec3 (*)(const Vec3&, const Vec3&, const Vec3&);

UnitNormal chosen_unit_normal() {
#if PALPATE_HAS_FMA_TARGET
  __builtin_cpu_init();
  if (__builtin_cpu_supports("fma")) return unit_normal_fma;
#endif
  return unit_normal_baseline;
}

}  // namespace

bool exactly_collinear(const Vec3& a, const Vec3& b, const Vec3& c) {
  if (component_certainly_nonzero(a, b, c, 0, 1) || component_certainly_nonzero(a, b, c, 1, 2) ||
      component_certainly_nonzero(a, b, c, 2, 0)) {
    return false;
  }
  if (a == b || b == c || c == a) return true;
  return scaled_cross(a, b, c) == Vec3::Zero();
}

Vec3 accurate_unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  static const UnitNormal chosen = chosen_unit_normal();
  return chosen(a, b, c);
}

}  // namespace palpate
