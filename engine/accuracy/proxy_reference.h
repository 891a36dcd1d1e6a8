#pragma once

// The proxies of a converged solver, to measure others against.

#include <cstdint>
#include <map>
#include <vector>

#include "geometry/base/types.h"

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

}  // namespace palpate
