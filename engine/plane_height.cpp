#include "engine/plane_height.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/placed_bounds.h"

namespace palpate {
namespace {

// The heights that one triangle, or several that overlap, is cut at: above low_m, up to high_m.
struct Heights {
  double low_m, high_m;
};

// Calls visit(heights) for each triangle that is not across A3.
template <typename Visit>
void visit_heights(const Scene& scene, const ScenePose& T_device_scene, const Visit& visit) {
  std::vector<double> height_of_vertex_m;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const SceneObject& object = scene.objects()[i];
    const AffineMap deformation = scene.deformation(i);
    const SurfaceMesh& mesh = scene.mesh(object.mesh);
    height_of_vertex_m.clear();
    for (const Vec3& p : mesh.welded_positions()) {
      const Vec3 p_scene = object.T_scene_body.point(deformation(p));
      height_of_vertex_m.push_back(T_device_scene.point(p_scene).z());
    }
    for (const Triangle& t : mesh.faces()) {
      const auto [low_m, high_m] = std::minmax(
          {height_of_vertex_m[t[0]], height_of_vertex_m[t[1]], height_of_vertex_m[t[2]]});
      if (low_m < high_m) visit(Heights{low_m, high_m});
    }
  }
}

// Without a gap between them, ascending.
std::vector<Heights> united(std::vector<Heights> heights) {
  std::sort(heights.begin(), heights.end(),
            [](const Heights& a, const Heights& b) { return a.low_m < b.low_m; });
  std::vector<Heights> whole;
  for (const Heights& h : heights) {
    if (whole.empty() || h.low_m > whole.back().high_m) {
      whole.push_back(h);
    } else {
      whole.back().high_m = std::max(whole.back().high_m, h.high_m);
    }
  }
  return whole;
}

}  // namespace

std::optional<double> height_with_contour_m(const Scene& scene, const ScenePose& T_device_scene) {
  constexpr double kInsidePerExtent = 1.0 / 64;
  if (scene.objects().empty()) return std::nullopt;
  const Box bounds = bounds_in_device(scene, T_device_scene);
  const double middle_m = 0.5 * bounds.low.z() + 0.5 * bounds.high.z();
  bool is_cut = false;
  visit_heights(scene, T_device_scene, [&](const Heights& h) {
    is_cut = is_cut || (h.low_m < middle_m && middle_m <= h.high_m);
  });
  if (is_cut) return middle_m;
  std::vector<Heights> heights;
  visit_heights(scene, T_device_scene, [&](const Heights& h) { heights.push_back(h); });
  const double most_inside_m = kInsidePerExtent * (bounds.high.z() - bounds.low.z());
  std::optional<double> nearest_m;
  for (const Heights& h : united(std::move(heights))) {
    const double inside_m = std::min(most_inside_m, 0.5 * (h.high_m - h.low_m));
    const double height_m = h.low_m >= middle_m ? h.low_m + inside_m : h.high_m - inside_m;
    if (!nearest_m || std::abs(height_m - middle_m) < std::abs(*nearest_m - middle_m)) {
      nearest_m = height_m;
    }
  }
  return nearest_m;
}

}  // namespace palpate
