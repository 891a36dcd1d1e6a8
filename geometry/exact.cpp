#include "geometry/exact.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>

namespace palpate {
namespace {

constexpr double kHalfUlpOfOne = 0x1p-53;

struct TwoTerms {  // their exact sum is meant; high is that sum rounded
  double high;
  double low;
};

TwoTerms two_sum(double a, double b) {
  const double sum = a + b;
  const double from_b = sum - a;
  const double from_a = sum - from_b;
  return {sum, (a - from_a) + (b - from_b)};
}

TwoTerms two_difference(double a, double b) {
  return two_sum(a, -b);
}

TwoTerms two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// An exact sum of up to 16 doubles, held as terms that do not overlap, the smallest first
// (Shewchuk's grow-expansion with zero elimination).
class Expansion {
 public:
  void add(double term) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const TwoTerms sum = two_sum(term, terms_[i]);
      if (sum.low != 0.0) terms_[kept++] = sum.low;
      term = sum.high;
    }
    if (term != 0.0) terms_[kept++] = term;
    size_ = kept;
  }

  void add_product(const TwoTerms& a, const TwoTerms& b, double sign) {
    for (const double a_term : {a.low, a.high}) {
      for (const double b_term : {b.low, b.high}) {
        const TwoTerms product = two_product(sign * a_term, b_term);
        add(product.low);
        add(product.high);
      }
    }
  }

  // Within an ulp, and zero iff the sum is.
  double rounded() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += terms_[i];
    return sum;
  }

 private:
  std::array<double, 16> terms_;  // only the first size_ have a value
  std::size_t size_ = 0;
};

// The component of (b - a) x (c - a) along the axis that completes axes i and j, within two ulp of
// itself and zero iff it is zero, for corners from scaled_corners().
double cross_component(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  const TwoTerms b_i = two_difference(b[i], a[i]);
  const TwoTerms b_j = two_difference(b[j], a[j]);
  const TwoTerms c_i = two_difference(c[i], a[i]);
  const TwoTerms c_j = two_difference(c[j], a[j]);
  const TwoTerms left = two_product(b_i.high, c_j.high);
  const TwoTerms right = two_product(b_j.high, c_i.high);
  const double mixed =
      (b_i.high * c_j.low + b_i.low * c_j.high) - (b_j.high * c_i.low + b_j.low * c_i.high);
  const double value = (left.high - right.high) + (mixed + (left.low - right.low));

  // With e half an ulp of 1 and m the size below, rounding costs 6 e^2 m in `mixed`, e^2 m in the
  // low terms and 3 e^2 m in their sum; the products of two low terms, left out, are at most e^2 m.
  // All of it is less than e |value| when m <= |value| / (16 e). The difference of the high terms
  // is exact where they nearly cancel, else within e |value|; so is the last sum.
  const double size = std::abs(left.high) + std::abs(right.high);
  if (16.0 * kHalfUlpOfOne * size <= std::abs(value)) return value;

  Expansion exact;
  exact.add_product(b_i, c_j, 1.0);
  exact.add_product(b_j, c_i, -1.0);
  return exact.rounded();
}

// True if that component certainly is not zero, judged from the corners as they are.
bool component_certainly_nonzero(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  const double left = (b[i] - a[i]) * (c[j] - a[j]);
  const double right = (b[j] - a[j]) * (c[i] - a[i]);
  // Three roundings of at most half an ulp of either product; the last term covers underflow.
  // An overflow makes the comparison false.
  const double rounding = 4.0 * kHalfUlpOfOne * (std::abs(left) + std::abs(right));
  return std::abs(left - right) > rounding + std::numeric_limits<double>::min();
}

struct Corners {
  Vec3 a, b, c;
};

// The corners times one power of two, which brings the largest coordinate to about 2^500: squares
// of coordinates are then far from overflow, products of their last bits above underflow.
Corners scaled_corners(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double largest =
      std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
  if (largest == 0.0) return {a, b, c};
  // Not more than a double can hold: what is scaled by less has no bits further down.
  const double scale = std::ldexp(1.0, std::min(500 - std::ilogb(largest), 1023));
  return {a * scale, b * scale, c * scale};
}

// (b - a) x (c - a), times a power of two.
Vec3 scaled_cross(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Corners s = scaled_corners(a, b, c);
  return {cross_component(s.a, s.b, s.c, 1, 2), cross_component(s.a, s.b, s.c, 2, 0),
          cross_component(s.a, s.b, s.c, 0, 1)};
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
  const Vec3 cross = scaled_cross(a, b, c);
  const double largest = cross.cwiseAbs().maxCoeff();
  assert(largest > 0.0);
  // In two steps: the power of two may be out of a double's range, its square root is not.
  const int exponent = std::ilogb(largest);
  const Vec3 near_one =
      (cross * std::ldexp(1.0, -exponent / 2)) * std::ldexp(1.0, exponent / 2 - exponent);
  return near_one / near_one.norm();
}

}  // namespace palpate
