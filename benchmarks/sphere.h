#pragma once

// The sphere that every benchmark runs on, as Palpate sees it and as its peers do.

#include <cstddef>

#include "benchmarks/cgal_surface.h"
#include "benchmarks/stock_embree.h"
#include "engine/scene.h"

namespace palpate::bench {

inline constexpr double kSphereRadius_m = 0.1;

// 20 * 4^subdivisions.
constexpr std::size_t sphere_triangles(int subdivisions) {
  return std::size_t{20} << (2 * subdivisions);
}

// The icosphere of kSphereRadius_m about the origin. Of each function the last answer is kept, so
// benchmarks of one size should follow each other; another question destroys it.

// For a proxy of that radius; null if it could not be compiled.
const Scene* sphere_scene(int subdivisions, double proxy_radius_m);

const StockSurface& stock_sphere(int subdivisions);

// Requires kHaveCgal.
const CgalSurface& cgal_sphere(int subdivisions);

inline const SurfaceIndex& index_of(const Scene& scene) {
  return *scene.world().bodies.front().index;
}

}  // namespace palpate::bench
