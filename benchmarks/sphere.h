#pragma once

// The sphere that every benchmark runs on, as Palpate sees it and as Embree alone does.

#include <cstddef>

#include "benchmarks/stock_embree.h"
#include "engine/scene.h"

namespace palpate::bench {

inline constexpr double kSphereRadius_m = 0.1;

// 20 * 4^subdivisions.
constexpr std::size_t sphere_triangles(int subdivisions) {
  return std::size_t{20} << (2 * subdivisions);
}

struct Sphere {
  Scene scene;
  StockSurface stock;

  const SurfaceIndex& index() const { return *scene.world().bodies.front().index; }
};

// The icosphere of kSphereRadius_m about the origin. The last one asked for is kept, so benchmarks
// of one size should follow each other. Null if it could not be compiled.
const Sphere* sphere(int subdivisions);

}  // namespace palpate::bench
