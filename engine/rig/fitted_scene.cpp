#include "engine/rig/fitted_scene.h"

#include <utility>

#include "engine/rig/workspace.h"

namespace palpate {

Result<FittedScene> load_fitted(const RunSetup& setup, const SceneFit& fit,
                                const std::function<Result<Scene>(const SceneSettings&)>& load) {
  SceneSettings settings = fit.scene;
  if (fit.fits_workspace) settings.close_gaps_m = 0.0;
  auto scene = load(settings);
  if (!scene) return scene.error();
  auto misfit = check_fits(*scene, setup);
  const bool is_final = !misfit && fit.scene.close_gaps_m == 0.0;
  if (!fit.fits_workspace || is_final) return FittedScene{std::move(*scene), std::move(misfit)};
  settings = fit.scene;
  if (misfit) settings.fit_size_m = fitting_size_m(*scene, setup).value_or(0.0);
  // Both scenes together would need twice the allowed memory.
  { const Scene not_fitting = std::move(*scene); }
  auto fitted = load(settings);
  if (!fitted) return fitted.error();
  misfit = check_fits(*fitted, setup);
  return FittedScene{std::move(*fitted), std::move(misfit)};
}

}  // namespace palpate
