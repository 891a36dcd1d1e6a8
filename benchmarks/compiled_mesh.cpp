#include "benchmarks/compiled_mesh.h"

#include <utility>

namespace palpate::bench {

std::optional<Scene> compile_mesh(const std::string& name, TriangleMesh mesh,
                                  double proxy_radius_m) {
  SceneDescription description;
  description.meshes.push_back({name, std::move(mesh.positions_m), std::move(mesh.triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = name;
  description.tree.resize(1);
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  Result<Scene> scene = Scene::compile(std::move(description), settings);
  if (!scene) return std::nullopt;
  return std::move(*scene);
}

}  // namespace palpate::bench
