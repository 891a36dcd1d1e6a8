#include "engine/session/closed_surfaces.h"

#include <algorithm>
#include <limits>

#include "geometry/base/printable.h"
#include "haptics/enclosure_search.h"

namespace palpate {

ClosedSurfaces::ClosedSurfaces(const Scene& scene, const std::optional<Vec3>& p_scene_m) {
  std::size_t count = 0;
  for (const SceneObject& object : scene.objects()) {
    count = std::max<std::size_t>(count, object.mesh + 1);
  }
  of_meshes_.resize(count);
  std::vector<bool> is_known(count);
  for (std::size_t o = 0; o < scene.objects().size(); ++o) {
    const std::uint32_t mesh = scene.objects()[o].mesh;
    if (is_known[mesh]) continue;
    const ContactWorld& world = scene.world();
    const bool is_needed =
        !p_scene_m || world.bodies[o].box_solver().contains(world.to_solver(*p_scene_m));
    if (!is_needed) continue;
    is_known[mesh] = true;
    of_meshes_[mesh] = closed_parts(scene.mesh(mesh).faces());
  }
  of_objects_.reserve(scene.objects().size());
  for (const SceneObject& object : scene.objects()) {
    of_objects_.push_back(&of_meshes_[object.mesh]);
    are_none_ = are_none_ && of_objects_.back()->count == 0;
  }
}

std::optional<std::size_t> enclosing_object(const Scene& scene, const Vec3& p_scene_m) {
  const ClosedSurfaces surfaces(scene, p_scene_m);
  if (surfaces.are_none()) return std::nullopt;
  const LiveWorld world(scene.world());
  EnclosingBodySearch search(surfaces.of_objects());
  WorkMeter unlimited(std::numeric_limits<WorkUnits>::max());
  search.search(world, scene.world().to_solver(p_scene_m), unlimited);
  if (search.body() == EnclosingBodySearch::kNone) return std::nullopt;
  return search.body();
}

std::string object_text(const Scene& scene, std::size_t object) {
  return "node \"" + printable(scene.objects()[object].name) + "\"";
}

}  // namespace palpate
