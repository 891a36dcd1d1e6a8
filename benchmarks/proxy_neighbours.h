#pragma once

// The number of triangles near a sphere proxy.

#include <vector>

#include "engine/scene/scene.h"

namespace palpate::bench {

// Mean numbers of triangles over proxy positions.
struct ProxyNeighbours {
  double under = 0.0;     // within one proxy radius of the touched point
  double in_reach = 0.0;  // within the proxy's radius plus one step of its centre
};

// Means over a sample of the given positions of the proxy's centre; the proxy must be in contact at
// each position. Tests every triangle of the scene, without the index.
ProxyNeighbours mean_proxy_neighbours(const Scene& scene, const std::vector<Vec3>& proxies_scene_m,
                                      double proxy_radius_m, double step_m);

}  // namespace palpate::bench
