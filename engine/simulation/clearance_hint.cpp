#include "engine/simulation/clearance_hint.h"

#include <sstream>

#include "engine/rig/placed_bounds.h"
#include "engine/rig/workspace.h"
#include "engine/simulation/plane_height.h"

namespace palpate {
namespace {

// Scaling the scene by k is equivalent to scaling the hand by 1 / k.
bool has_path_at(const Scene& scene, const SurfacePathSettings& wanted, double factor) {
  SurfacePathSettings smaller = wanted;
  smaller.length_m /= factor;
  smaller.leg_m /= factor;
  smaller.room_m /= factor;
  return plan_surface_path(scene, smaller).has_value();
}

// Whether a device that senses A1 and A2 has a contour within its workspace.
bool has_contour(const Scene& scene, const RunSetup& setup) {
  const ScenePose& pose = setup.haptics.initial_pose;
  const double largest_m = scene.statistics().extent_m.maxCoeff();
  return !check_fits(hand_workspace(2, workspace_extent_m(setup.device)),
                     bounds_in_device(scene, pose), largest_m) &&
         height_with_contour_m(scene, pose).has_value();
}

std::string two_sensors_text(const ActuationModel& actuation) {
  return actuation.actuators() > 2
             ? "use `RunSettings::sensors` 2 with at most two `RunSettings::actuators`"
             : "use `RunSettings::sensors` 2";
}

}  // namespace

std::string clearance_hint(const Scene& scene, const RunSetup& setup,
                           const SurfacePathSettings& wanted) {
  const Workspace workspace = hand_workspace(setup);
  const Box bounds = bounds_in_device(scene, setup.haptics.initial_pose);
  const double largest_m = scene.statistics().extent_m.maxCoeff();
  for (const auto& size_m : {fitting_size_m(workspace, bounds, largest_m),
                             largest_size_m(workspace, bounds, largest_m)}) {
    if (!size_m || *size_m <= largest_m) continue;
    if (!has_path_at(scene, wanted, *size_m / largest_m)) continue;
    std::ostringstream hint;
    hint << "scale the scene up with `SceneSettings::fit_size_m` " << *size_m;
    return hint.str();
  }
  if (has_contour(scene, setup)) return two_sensors_text(setup.actuation);
  return scene.objects().size() > 1
             ? "no size within `RunSettings::device.workspace` gives enough clearance: load a part "
               "of the scene with `SceneSettings::node`"
             : "no size within `RunSettings::device.workspace` gives enough clearance: choose a "
               "scene with larger faces";
}

}  // namespace palpate
