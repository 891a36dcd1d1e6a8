#include "benchmarks/sphere.h"

#include <optional>
#include <utility>

#include "benchmarks/compiled_mesh.h"
#include "benchmarks/last_built.h"
#include "models/primitives.h"

namespace palpate::bench {

const Scene* sphere_scene(int subdivisions, double proxy_radius_m) {
  static LastBuilt<std::pair<int, double>, Scene> last;
  const std::optional<Scene>& scene = last.get({subdivisions, proxy_radius_m}, [&] {
    return compile_mesh("sphere", icosphere(subdivisions, kSphereRadius_m), proxy_radius_m);
  });
  return scene ? &*scene : nullptr;
}

const SurfaceIndex& sphere_index(int subdivisions) {
  static LastBuilt<int, SurfaceIndex> last;
  return *last.get(subdivisions, [&] {
    const TriangleMesh mesh = icosphere(subdivisions, kSphereRadius_m);
    return std::optional<SurfaceIndex>(SurfaceMesh::build(mesh.positions_m, mesh.triangles));
  });
}

const StockSurface& stock_sphere(int subdivisions) {
  static LastBuilt<int, StockSurface> last;
  return *last.get(subdivisions, [&] {
    return std::optional<StockSurface>(icosphere(subdivisions, kSphereRadius_m));
  });
}

const CgalSurface& cgal_sphere(int subdivisions) {
  static LastBuilt<int, CgalSurface> last;
  return *last.get(subdivisions, [&] {
    return std::optional<CgalSurface>(icosphere(subdivisions, kSphereRadius_m));
  });
}

}  // namespace palpate::bench
