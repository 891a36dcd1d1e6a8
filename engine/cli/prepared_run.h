#pragma once

// The scene and the settings of `run` before the hand moves.

#include "engine/cli/run_command.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

struct PreparedRun {
  Scene scene;
  RunSetup setup;  // with a chosen plane height if the user stated none
};

// Loads the scene, scaled to the workspace under --fit auto, and chooses the plane of a planar
// device. An error if the scene does not fit; it names the option to change.
Result<PreparedRun> prepare_run(const RunRequest& command);

}  // namespace palpate
