#pragma once

// The scene of a rig, at a size that fits the workspace of the device.

#include <functional>
#include <optional>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

// How a scene lies in the workspace, beside its pose (HapticSettings::initial_pose).
struct SceneFit {
  SceneSettings scene;          // with its scale or its size
  bool fits_workspace = false;  // scale the scene to the workspace if it does not fit; no scale and
                                // no size must be set then
};

struct FittedScene {
  Scene scene;
  std::optional<Error> misfit;  // see check_fits()
};

// Loads the scene for a rig with this setup, a second time if it must be scaled. The width of gaps
// (SceneSettings::close_gaps_m) is one of the scene in its final size. load: loads the scene, such
// as Scene::load(). Returns the errors of load; a scene that does not fit is none.
Result<FittedScene> load_fitted(const RunSetup& setup, const SceneFit& fit,
                                const std::function<Result<Scene>(const SceneSettings&)>& load);

}  // namespace palpate
