#include "engine/scene/scene.h"

#include <utility>

#include "engine/scene/extras_keys.h"
#include "engine/scene/memory_budget.h"
#include "engine/scene/scene_compiler.h"
#include "io/gltf/reader.h"

namespace palpate {
namespace {

Error with_path(Error error, const std::string& path) {
  error.path = path;
  return error;
}

}  // namespace

Result<Scene> Scene::load(const std::string& path, const SceneSettings& settings) {
  MemoryLedger ledger;
  Result<Scene> scene = or_out_of_memory(ledger, [&]() -> Result<Scene> {
    ledger.begin("loading the scene");
    ReadOptions options{settings.overrides, settings.pose};
    options.memory = memory_limit(settings.max_memory_bytes);
    options.scene = settings.listed_scene;
    options.feels_hidden = settings.feels_hidden;
    options.key_names = &extras_keys();
    Result<SceneDescription> description = read_gltf(path, options);
    if (!description) return description.error();
    ledger = MemoryLedger(std::move(options.memory));
    return SceneCompiler(std::move(*description), settings, ledger).run();
  });
  if (!scene && scene.error().path.empty()) return with_path(scene.error(), path);
  return scene;
}

Result<Scene> Scene::compile(SceneDescription description, const SceneSettings& settings) {
  MemoryLedger ledger;
  return or_out_of_memory(ledger, [&]() -> Result<Scene> {
    ledger.begin("compiling the scene");
    ledger = MemoryLedger(memory_limit(settings.max_memory_bytes));
    return SceneCompiler(std::move(description), settings, ledger).run();
  });
}

std::optional<std::uint32_t> Scene::material(std::size_t object, std::size_t face) const {
  const MeshParts& parts = parts_[objects_[object].mesh];
  return parts.materials()[parts.part_of_face(face)];
}

std::string_view Scene::body_name(std::int32_t body) const {
  if (body < 0 || static_cast<std::size_t>(body) >= objects_.size()) return {};
  return objects_[static_cast<std::size_t>(body)].name;
}

std::string_view Scene::material_name(std::int32_t material) const {
  if (material < 0 || static_cast<std::size_t>(material) >= materials_.size()) return {};
  return materials_[static_cast<std::size_t>(material)].name;
}

AffineMap Scene::map_body_mesh(const IndexUse& use) const {
  const AffineMap& map = shapes_[use.shape].map_index_mesh;
  if (use.stretch == IndexUse::kNoStretch) return map;
  const Mat3& linear = (*world_.stretches)[use.stretch].linear_body_index();
  return {linear * map.linear, linear * map.translation_m};
}

AffineMap Scene::map_body_mesh(std::size_t object) const {
  return map_body_mesh(use_of_object_[object]);
}

AffineMap Scene::deformation(std::size_t object) const {
  const double metres_per_unit = use_of_object_[object].metres_per_unit;
  const AffineMap map = map_body_mesh(object);
  return {metres_per_unit * map.linear, metres_per_unit * map.translation_m};
}

void Scene::append_triangles_scene(std::vector<Vec3>& positions_m,
                                   std::vector<Triangle>& triangles) const {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const SceneObject& object = objects_[i];
    const SurfaceMesh& mesh = meshes_[object.mesh];
    const double metres_per_unit = use_of_object_[i].metres_per_unit;
    const AffineMap map = map_body_mesh(i);
    const auto first = static_cast<std::uint32_t>(positions_m.size());
    for (const Vec3& p : mesh.welded_positions()) {
      positions_m.push_back(object.T_scene_body.point(metres_per_unit * map(p)));
    }
    const bool mirrored = metres_per_unit * map.linear.determinant() < 0.0;
    for (const Triangle& t : mesh.faces()) {
      triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }
}

}  // namespace palpate
