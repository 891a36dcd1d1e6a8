#pragma once

// The proxies of a converged solver, to measure others against.

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "geometry/types.h"

namespace palpate {

// Proxies of ticks in contact, kept by seed: every level asks for the same ones.
class ProxyReference {
 public:
  // make(): runs the reference. Scene frame, metres.
  template <typename Make>
  const std::vector<Vec3>& get(std::uint64_t seed, Make make) {
    auto [place, is_new] = proxies_.try_emplace(seed);
    if (is_new) place->second = make();
    return place->second;
  }

 private:
  std::map<std::uint64_t, std::vector<Vec3>> proxies_;
};

// Root mean square of what is added.
class RootMeanSquare {
 public:
  void add(double x) {
    sum_ += x * x;
    count_ += 1.0;
  }
  double value() const { return count_ > 0.0 ? std::sqrt(sum_ / count_) : 0.0; }

 private:
  double sum_ = 0.0;
  double count_ = 0.0;
};

// What a file's coordinates are rounded to: half the step of single precision at the farthest of
// them. Errors below say nothing about a scene that came from a file.
inline double float_floor_m(double farthest_coordinate_m) {
  return 0.5 * std::numeric_limits<float>::epsilon() * farthest_coordinate_m;
}

}  // namespace palpate
