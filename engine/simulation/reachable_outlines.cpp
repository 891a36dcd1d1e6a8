#include "engine/simulation/reachable_outlines.h"

#include <sstream>
#include <utility>

#include "engine/rig/placed_bounds.h"
#include "engine/simulation/ball_outline.h"
#include "engine/simulation/scene_cut.h"

namespace palpate {
namespace {

Error contour_too_crowded(const std::vector<Polyline>& section, const char* how) {
  return {ErrorCode::kLimitExceeded, "", "scene",
          "has " + std::to_string(section.size()) + " curves in the plane, too many of which " +
              how + " to compute their common contour",
          "load a part of the scene with `SceneSettings::node`, or use `RunSettings::sensors` 3, "
          "which needs no contour"};
}

Error nothing_at_height(const Scene& scene, const ScenePose& pose) {
  const Box bounds = bounds_in_device(scene, pose);
  std::ostringstream range;
  range << "the scene spans " << bounds.low.z() << " to " << bounds.high.z() << " m along A3";
  return {ErrorCode::kInvalidArgument, "", "plane_height_m",
          "has no contour at this height: " + range.str(),
          "choose a height in between, or use 3 sensors"};
}

}  // namespace

Result<std::vector<Outline>> reachable_outlines(const Scene& scene, const ScenePose& T_device_scene,
                                                double plane_height_m, double small_m,
                                                double proxy_radius_m) {
  const Vec3 normal = T_device_scene.inverse_direction(Vec3::UnitZ());
  const double offset_m = plane_height_m - T_device_scene.translation_m.z();
  const std::vector<Polyline> section = cut_scene(scene, normal, offset_m);
  if (section.empty()) return nothing_at_height(scene, T_device_scene);
  auto found = outlines(section, normal, small_m);
  if (!found) return contour_too_crowded(section, "cross each other");
  // If solids are inside out, no outline may be found; the longest curve is used.
  if (found->empty()) found->push_back({section.front(), !section.front().closed});
  if (proxy_radius_m > 0.0 && found->front().curve.closed) {
    auto touched = ball_outlines(*found, normal, proxy_radius_m);
    if (!touched) return contour_too_crowded(section, "are within a sphere of each other");
    if (!touched->empty()) found = std::move(touched);
  }
  return std::move(*found);
}

}  // namespace palpate
