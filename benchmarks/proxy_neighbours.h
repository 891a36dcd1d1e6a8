#pragma once

// How crowded it is around a sphere proxy.

#include <vector>

#include "engine/scene/scene.h"

namespace palpate::bench {

// Numbers of triangles, means over proxy positions.
struct ProxyNeighbours {
  double under = 0.0;     // within one proxy radius of the point the proxy touches
  double in_reach = 0.0;  // within the proxy's radius and one step of its centre
};

// Over some of the positions of the proxy's centre, each of which must be in contact. By comparing
// with every triangle of the scene, whatever its index may say.
ProxyNeighbours mean_proxy_neighbours(const Scene& scene, const std::vector<Vec3>& proxies_scene_m,
                                      double proxy_radius_m, double step_m);

}  // namespace palpate::bench
