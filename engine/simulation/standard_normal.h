#pragma once

#include <cmath>
#include <numbers>
#include <random>

namespace palpate {

// A random number from the normal distribution with mean 0 and variance 1: the Box-Muller transform
// of the generator's bits. It is equal wherever log and cos of the C library are equal.
inline double standard_normal(std::mt19937_64& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

}  // namespace palpate
