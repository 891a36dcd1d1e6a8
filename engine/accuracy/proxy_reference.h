#pragma once

// The proxy positions of a converged solver, as the reference for other solvers.

#include <cstdint>
#include <map>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

// The proxy positions of the ticks in contact. They are kept for each seed, because every level
// uses the same reference.
class ProxyReference {
 public:
  // Returns the positions for this seed, in the scene frame, metres. On first use, make() computes
  // them.
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
