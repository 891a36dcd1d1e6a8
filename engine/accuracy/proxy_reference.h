#pragma once

// The proxies of a converged solver, as the reference of other proxies.

#include <cstdint>
#include <map>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// Proxies of ticks in contact, kept by seed, because every level uses the same proxies.
class ProxyReference {
 public:
  // make() runs the reference on first use. Scene frame, metres.
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
