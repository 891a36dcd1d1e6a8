#pragma once

// Seeded random numbers for property tests. A failing test prints its seed; PALPATE_SEED=N in the
// environment repeats the test with seed N.

#include <cstdint>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "geometry/base/random.h"

namespace palpate::test {

class Random : public SeededRandom {
 public:
  // default_seed: the fixed seed of the test, so that CI runs are repeatable.
  explicit Random(std::uint64_t default_seed) : Random(Seed{seed_from_environment(default_seed)}) {}

  std::uint64_t seed() const { return seed_; }

 private:
  struct Seed {
    std::uint64_t value;
  };
  explicit Random(Seed seed)
      : SeededRandom(seed.value),
        seed_(seed.value),
        trace_(__FILE__, __LINE__, "PALPATE_SEED=" + std::to_string(seed_)) {}

  static std::uint64_t seed_from_environment(std::uint64_t fallback) {
    const char* text = std::getenv("PALPATE_SEED");
    return text ? std::strtoull(text, nullptr, 10) : fallback;
  }

  std::uint64_t seed_;
  testing::ScopedTrace trace_;
};

}  // namespace palpate::test
