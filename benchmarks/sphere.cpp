#include "benchmarks/sphere.h"

#include <memory>
#include <utility>

#include "models/primitives.h"

namespace palpate::bench {
namespace {

std::unique_ptr<Sphere> build_sphere(int subdivisions) {
  TriangleMesh mesh = icosphere(subdivisions, kSphereRadius_m);
  StockSurface stock(mesh);
  SceneDescription description;
  description.meshes.push_back({"sphere", std::move(mesh.positions_m), std::move(mesh.triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = "sphere";
  description.node_count = 1;
  Result<Scene> scene = Scene::compile(std::move(description));
  if (!scene) return nullptr;
  return std::make_unique<Sphere>(Sphere{std::move(*scene), std::move(stock)});
}

}  // namespace

const Sphere* sphere(int subdivisions) {
  static std::unique_ptr<Sphere> built;
  static int built_subdivisions = -1;
  if (built_subdivisions != subdivisions) {
    built.reset();  // first, so that two large ones never share the memory
    built = build_sphere(subdivisions);
    built_subdivisions = subdivisions;
  }
  return built.get();
}

}  // namespace palpate::bench
