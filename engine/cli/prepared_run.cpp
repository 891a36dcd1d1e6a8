#include "engine/cli/prepared_run.h"

#include <optional>
#include <utility>

#include "engine/simulation/placed_bounds.h"
#include "engine/simulation/plane_height.h"
#include "engine/simulation/workspace.h"

namespace palpate {
namespace {

Workspace workspace_of(const RunSetup& setup) {
  return hand_workspace(setup.actuation.sensors(), workspace_extent_m(setup.device));
}

std::optional<Error> check_fits(const PreparedRun& run) {
  if (run.scene.objects().empty()) return std::nullopt;  // explore() has the error
  return check_fits(workspace_of(run.setup),
                    bounds_in_device(run.scene, run.setup.haptics.initial_pose),
                    run.scene.statistics().extent_m.maxCoeff());
}

// Loads the scene again, at the size that fits if it does not. The first scene is destroyed before:
// both together would need twice the allowed memory.
Result<PreparedRun> load_fitted(const RunRequest& command, PreparedRun run, bool is_fitting) {
  std::optional<double> size_m;
  if (!is_fitting) {
    size_m = fitting_size_m(workspace_of(run.setup),
                            bounds_in_device(run.scene, run.setup.haptics.initial_pose),
                            run.scene.statistics().extent_m.maxCoeff());
  }
  RunSetup setup = std::move(run.setup);
  { const Scene not_fitting = std::move(run.scene); }
  SceneOptions scene = command.scene;
  scene.fits_workspace = false;
  scene.fit_size_m = size_m;
  auto fitted = load_scene(scene, command.options.settings);
  if (!fitted) return fitted.error();
  return PreparedRun{std::move(*fitted), std::move(setup)};
}

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
  SceneOptions unscaled = command.scene;
  unscaled.fits_workspace = false;
  // The width of gaps is one of the scene in its final size.
  if (command.scene.fits_workspace) unscaled.close_gaps_m.reset();
  auto scene = load_scene(unscaled, command.options.settings);
  if (!scene) return scene.error();
  PreparedRun run{std::move(*scene), std::move(*setup)};
  auto misfit = check_fits(run);
  if (command.scene.fits_workspace && (misfit || command.scene.close_gaps_m)) {
    auto fitted = load_fitted(command, std::move(run), !misfit);
    if (!fitted) return fitted.error();
    run = std::move(*fitted);
    misfit = check_fits(run);
  }
  // A --place that is too far away is the cause of a misfit, so its error comes first.
  const bool has_hand = command.device.text.empty();
  if (misfit && has_hand) return check_setup(run.scene, run.setup).value_or(*misfit);
  if (const auto error = choose_plane(command, run)) return *error;
  return run;
}

}  // namespace palpate
