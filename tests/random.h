#pragma once

// Seeded randomness for property tests. Every test prints its seed when it fails; PALPATE_SEED=N
// in the environment runs it again with that one.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "geometry/types.h"

namespace palpate::test {

class Random {
 public:
  // default_seed: the fixed seed of the test, so that CI runs are repeatable.
  explicit Random(std::uint64_t default_seed)
      : seed_(seed_from_environment(default_seed)),
        engine_(seed_),
        trace_(__FILE__, __LINE__, "PALPATE_SEED=" + std::to_string(seed_)) {}

  std::uint64_t seed() const { return seed_; }

  // Uniform in [low, high), made from the engine's bits so that every platform agrees.
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  std::uint64_t index(std::uint64_t count) { return engine_() % count; }
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
    return radius * std::cos(uniform(0.0, 2.0 * std::numbers::pi));
  }
  Vec3 in_box(double half_extent) {
    const double x = uniform(-half_extent, half_extent);
    const double y = uniform(-half_extent, half_extent);
    return {x, y, uniform(-half_extent, half_extent)};
  }
  Vec3 unit_vector() {
    const double x = normal();
    const double y = normal();
    return Vec3(x, y, normal()).normalized();
  }
  // Uniform over rotations.
  Quat rotation() {
    const double w = normal();
    const double x = normal();
    const double y = normal();
    return Quat(w, x, y, normal()).normalized();
  }
  RigidTransform pose(double half_extent_m) { return {rotation(), in_box(half_extent_m)}; }

 private:
  static std::uint64_t seed_from_environment(std::uint64_t fallback) {
    const char* text = std::getenv("PALPATE_SEED");
    return text ? std::strtoull(text, nullptr, 10) : fallback;
  }

  std::uint64_t seed_;
  std::mt19937_64 engine_;
  testing::ScopedTrace trace_;
};

}  // namespace palpate::test
