#include "engine/cli/prepared_run.h"

#include <utility>

#include "engine/rig/fitted_scene.h"
#include "engine/simulation/plane_height.h"

namespace palpate {
namespace {

std::optional<Error> choose_plane(const RunRequest& command, PreparedRun& run) {
  if (!run.setup.actuation.is_planar() || command.options.settings.plane_height_m ||
      run.scene.objects().empty()) {
    return std::nullopt;
  }
  const auto height_m = height_with_contour_m(run.scene, run.setup.haptics.initial_pose);
  if (!height_m) {
    return Error{ErrorCode::kInvalidArgument, "", "--plane-height",
                 "has no suitable value: every face lies across A3, so no height has a contour",
                 "turn the scene with --place \"0 0 0 0.7071068 0.7071068 0 0\", or use "
                 "--sensors 3"};
  }
  run.setup.haptics.plane_height_m = *height_m;
  return std::nullopt;
}

}  // namespace

Result<PreparedRun> prepare_run(const RunRequest& command) {
  auto setup = make_setup(command.options);
  if (!setup) return setup.error();
  if (command.scene.fits_workspace && command.scene.scale) {
    return Error{ErrorCode::kInvalidArgument, "", "--fit",
                 "is used together with --scale; use one of them", ""};
  }
  if (const auto error = check_exploration(command.exploration, setup->dt_s)) return *error;
  SceneOptions options = command.scene;
  options.fits_workspace = false;
  const RunSettings& settings = command.options.settings;
  auto scene_settings = scene_settings_of(options, settings.haptics.god_object.radius_m);
  if (!scene_settings) return scene_settings.error();
  auto fitted = load_fitted(
      *setup, {std::move(*scene_settings), command.scene.fits_workspace},
      [&](const SceneSettings& sized) { return load_scene(options, sized, settings.rate_Hz); });
  if (!fitted) return fitted.error();
  PreparedRun run{std::move(fitted->scene), std::move(*setup)};
  // A --place that is too far away is the cause of a misfit, so its error comes first.
  const bool has_hand = command.device.text.empty();
  if (fitted->misfit && has_hand) {
    return check_setup(run.scene, run.setup).value_or(*fitted->misfit);
  }
  if (const auto error = choose_plane(command, run)) return *error;
  return run;
}

}  // namespace palpate
