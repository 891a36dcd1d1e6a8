#pragma once

// Seeded random numbers. Uniform numbers are equal on every platform, because they use the bits of
// a standard engine and not the distributions of the standard library. Normal numbers, and what is
// made of them, also use log and cos of the C library, which may differ in the last bit.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "geometry/base/types.h"

namespace palpate {

class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : engine_(seed) {}

  // Uniform in [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  // An integer in [0, count). Requires count > 0.
  std::uint64_t index(std::uint64_t count) { return engine_() % count; }
  // Normal distribution with mean 0 and variance 1 (Box-Muller transform).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
    return radius * std::cos(uniform(0.0, 2.0 * std::numbers::pi));
  }
  Vec3 in_box(double half_extent) {
    const double x = uniform(-half_extent, half_extent);
    const double y = uniform(-half_extent, half_extent);
    return {x, y, uniform(-half_extent, half_extent)};
  }
  // Uniform over the unit sphere.
  Vec3 unit_vector() {
    const double x = normal();
    const double y = normal();
    return Vec3(x, y, normal()).normalized();
  }
  // Uniform over all rotations.
  Quat rotation() {
    const double w = normal();
    const double x = normal();
    const double y = normal();
    return Quat(w, x, y, normal()).normalized();
  }
  RigidTransform pose(double half_extent_m) { return {rotation(), in_box(half_extent_m)}; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace palpate
