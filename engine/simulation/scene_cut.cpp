#include "engine/simulation/scene_cut.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace palpate {

std::vector<Polyline> cut_scene(const Scene& scene, const Vec3& plane_normal,
                                double plane_offset_m) {
  std::vector<Polyline> curves;
  std::vector<Vec3> positions_m;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const SceneObject& object = scene.objects()[i];
    const SurfaceMesh& mesh = scene.mesh(object.mesh);
    const AffineMap deformation = scene.deformation(i);
    positions_m.clear();
    bool has_above = false;
    bool has_below = false;
    for (const Vec3& p : mesh.welded_positions()) {
      positions_m.push_back(object.T_scene_body.point(deformation(p)));
      const bool is_above = plane_normal.dot(positions_m.back()) - plane_offset_m >= 0.0;
      (is_above ? has_above : has_below) = true;
    }
    if (!has_above || !has_below) continue;
    std::vector<Triangle> triangles = mesh.faces();
    if (deformation.linear.determinant() < 0.0) {
      for (Triangle& t : triangles) std::swap(t[1], t[2]);
    }
    std::vector<Polyline> found =
        plane_section(positions_m, triangles, plane_normal, plane_offset_m);
    std::move(found.begin(), found.end(), std::back_inserter(curves));
  }
  std::stable_sort(curves.begin(), curves.end(),
                   [](const Polyline& a, const Polyline& b) { return length_m(a) > length_m(b); });
  return curves;
}

std::uint64_t scene_cut_bytes(const Scene& scene) {
  std::uint64_t most = 0;
  for (const SceneObject& object : scene.objects()) {
    const SurfaceMesh& mesh = scene.mesh(object.mesh);
    const std::uint64_t positions = mesh.welded_positions().size();
    const std::uint64_t faces = mesh.face_count();
    most = std::max(most, positions * (sizeof(Vec3) + sizeof(double)) + faces * sizeof(Triangle));
  }
  return most;
}

}  // namespace palpate
