#include "engine/accuracy/posed_sheet.h"

#include <string>
#include <utility>

namespace palpate {
namespace {

constexpr double kFarthest_m = 0.1;  // distance of the middle from the origin along each axis

MaterialDescription with_friction(double coefficient) {
  MaterialDescription material;
  material.name = "rubbing";
  material.element = "/materials/0";
  for (const char* key : {"staticFriction", "dynamicFriction"}) {
    material.parameters.push_back(
        {key, coefficient, std::string("/materials/0/extras/palpate/") + key});
  }
  return material;
}

}  // namespace

Result<PosedSheet> sheet_at(const RigidTransform& T_scene_sheet, double friction) {
  const double half_m = 0.5 * kSheetSize_m;
  SceneDescription description;
  description.meshes.push_back(
      {"sheet",
       {{-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}},
       {{0, 1, 2}, {0, 2, 3}}});
  if (friction > 0.0) {
    description.meshes.back().material_runs = {{0, 0}};
    description.materials.push_back(with_friction(friction));
  }
  NodeDescription node;
  node.name = "sheet";
  node.linear_scene_mesh = T_scene_sheet.rotation.toRotationMatrix();
  node.translation_m = T_scene_sheet.translation_m;
  description.nodes.push_back(node);
  description.tree.resize(1);
  Result<Scene> scene = Scene::compile(std::move(description));
  if (!scene) return scene.error();
  return PosedSheet{std::move(*scene), T_scene_sheet};
}

Result<PosedSheet> posed_sheet(SeededRandom& random, double friction) {
  return sheet_at(random.pose(kFarthest_m), friction);
}

}  // namespace palpate
