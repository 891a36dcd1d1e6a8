#pragma once

// Exact arithmetic on sums of doubles (J. R. Shewchuk, "Adaptive Precision Floating-Point
// Arithmetic and Fast Robust Geometric Predicates", 1997). Private to geometry. Requires rounding
// to nearest; no operation may overflow or underflow.

#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {

// The exact sum of two doubles: `high` is the rounded sum, `low` the rounding error.
struct TwoTerms {
  double high;
  double low;
};

inline TwoTerms two_sum(double a, double b) {
  const double sum = a + b;
  const double from_b = sum - a;
  const double from_a = sum - from_b;
  return {sum, (a - from_a) + (b - from_b)};
}

inline TwoTerms two_difference(double a, double b) {
  return two_sum(a, -b);
}

// Requires |a| >= |b| or a == 0.
inline TwoTerms ordered_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

inline TwoTerms two_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

inline TwoTerms negated(const TwoTerms& a) {
  return {-a.high, -a.low};
}

// An exact sum, stored as nonzero terms that do not overlap, in increasing order of magnitude.
template <std::size_t kCapacity>
struct Expansion {
  std::array<double, kCapacity> terms;  // only the first `size` terms are set
  std::size_t size = 0;

  void append(double term) {
    if (term != 0.0) terms[size++] = term;
  }
  // The sum, rounded to within one ulp; zero iff the exact sum is zero.
  double rounded() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < size; ++i) sum += terms[i];
    return sum;
  }
  int sign() const {
    if (size == 0) return 0;
    return terms[size - 1] > 0.0 ? 1 : -1;
  }
};

inline Expansion<2> expansion(const TwoTerms& a) {
  Expansion<2> e;
  e.append(a.low);
  e.append(a.high);
  return e;
}

// Shewchuk's FAST-EXPANSION-SUM: merges the terms by magnitude, then sums from the smallest up.
template <std::size_t kA, std::size_t kB>
Expansion<kA + kB> sum(const Expansion<kA>& a, const Expansion<kB>& b) {
  Expansion<kA + kB> result;
  std::size_t i = 0;
  std::size_t j = 0;
  const auto smallest_left = [&] {
    if (j == b.size) return a.terms[i++];
    if (i == a.size) return b.terms[j++];
    return std::abs(a.terms[i]) < std::abs(b.terms[j]) ? a.terms[i++] : b.terms[j++];
  };
  if (a.size + b.size == 0) return result;
  double running = smallest_left();
  while (i + j < a.size + b.size) {
    const TwoTerms next = two_sum(running, smallest_left());
    result.append(next.low);
    running = next.high;
  }
  result.append(running);
  return result;
}

// Shewchuk's SCALE-EXPANSION.
template <std::size_t kA>
Expansion<2 * kA> scaled(const Expansion<kA>& a, double factor) {
  Expansion<2 * kA> result;
  if (a.size == 0) return result;
  TwoTerms product = two_product(a.terms[0], factor);
  result.append(product.low);
  double running = product.high;
  for (std::size_t i = 1; i < a.size; ++i) {
    product = two_product(a.terms[i], factor);
    const TwoTerms low = two_sum(running, product.low);
    result.append(low.low);
    const TwoTerms high = ordered_sum(product.high, low.high);
    result.append(high.low);
    running = high.high;
  }
  result.append(running);
  return result;
}

template <std::size_t kA>
Expansion<4 * kA> product(const Expansion<kA>& a, const TwoTerms& b) {
  return sum(scaled(a, b.low), scaled(a, b.high));
}

}  // namespace palpate
