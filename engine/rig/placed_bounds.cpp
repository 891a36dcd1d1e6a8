#include "engine/rig/placed_bounds.h"

#include <optional>
#include <vector>

namespace palpate {
namespace {

// p_device = linear * p_mesh + translation_m, for the mesh of object i.
AffineMap map_device_mesh(const Scene& scene, std::size_t i, const ScenePose& T_device_scene) {
  const SceneObject& object = scene.objects()[i];
  const AffineMap deformation = scene.deformation(i);
  const Mat3 rotation_scene_body = object.T_scene_body.rotation.toRotationMatrix();
  const Mat3 rotation_device_scene = T_device_scene.rotation.toRotationMatrix();
  return {rotation_device_scene * rotation_scene_body * deformation.linear,
          T_device_scene.point(object.T_scene_body.point(deformation.translation_m))};
}

Box box_of(const SurfaceMesh& mesh, const AffineMap& map) {
  Box box = Box::empty();
  for (const Vec3& p : mesh.welded_positions()) {
    const Vec3 q = map(p);
    box = box.united({q, q});
  }
  return box;
}

Box box_around(const Box& box, const AffineMap& map) {
  const Vec3 centre = map(0.5 * box.low + 0.5 * box.high);
  const Vec3 reach_m = map.linear.cwiseAbs() * (0.5 * box.high - 0.5 * box.low);
  return {centre - reach_m, centre + reach_m};
}

}  // namespace

Box bounds_in_device(const Scene& scene, const ScenePose& T_device_scene) {
  std::vector<std::optional<Box>> boxes_mesh;
  Box bounds = Box::empty();
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const SceneObject& object = scene.objects()[i];
    if (object.mesh >= boxes_mesh.size()) boxes_mesh.resize(object.mesh + 1);
    const SurfaceMesh& mesh = scene.mesh(object.mesh);
    std::optional<Box>& box_mesh = boxes_mesh[object.mesh];
    if (!box_mesh) box_mesh = box_of(mesh, {});
    const AffineMap map = map_device_mesh(scene, i, T_device_scene);
    const Box around = box_around(*box_mesh, map);
    if (bounds.contains(around.low) && bounds.contains(around.high)) continue;
    bounds = bounds.united(box_of(mesh, map));
  }
  return bounds;
}

}  // namespace palpate
