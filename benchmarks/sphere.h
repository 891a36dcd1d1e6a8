#pragma once

// The sphere of the benchmarks, in the data structures of Palpate and of its peers.

#include <cstddef>

#include "benchmarks/cgal_surface.h"
#include "benchmarks/stock_embree.h"
#include "engine/scene/scene.h"

namespace palpate::bench {

inline constexpr double kSphereRadius_m = 0.1;

// The number of triangles of the sphere: 20 * 4^subdivisions.
constexpr std::size_t sphere_triangles(int subdivisions) {
  return std::size_t{20} << (2 * subdivisions);
}

// The sphere is the icosphere of kSphereRadius_m about the origin. Each of the following functions
// keeps its last result and destroys it when called with other arguments, so benchmarks of one size
// should run consecutively.

// The scene for a proxy of proxy_radius_m; null if it could not be compiled.
const Scene* sphere_scene(int subdivisions, double proxy_radius_m);

const StockSurface& stock_sphere(int subdivisions);

// The sphere in CGAL's tree. Requires kHaveCgal.
const CgalSurface& cgal_sphere(int subdivisions);

// The index of the sphere in metres, about the origin, for the comparison with the peers.
const SurfaceIndex& sphere_index(int subdivisions);

// The nearest point of the only body of a scene, scene frame.
inline std::optional<SurfacePoint> closest_point(const Scene& scene, const Vec3& p_scene,
                                                 double radius_m) {
  const ContactWorld& world = scene.world();
  const ContactBody& body = world.bodies.front();
  auto nearest = body.index->closest_point(body.to_body(world.to_solver(p_scene)),
                                           body.length_to_body(radius_m));
  if (!nearest) return std::nullopt;
  nearest->point_m = world.to_scene(body.to_solver(nearest->point_m));
  nearest->distance_m = (nearest->point_m - p_scene).norm();
  return nearest;
}

}  // namespace palpate::bench
