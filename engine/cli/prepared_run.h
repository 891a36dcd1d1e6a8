#pragma once

// What `run` makes of its options before the hand moves.

#include "engine/cli/run_command.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

struct PreparedRun {
  Scene scene;
  RunSetup setup;  // with the plane height that was chosen where none was given
};

// Loads the scene, at the size that fits the workspace if it is to be fitted; refuses one that does
// not fit; and lays the plane of a planar device through it. An error names the option to change.
Result<PreparedRun> prepare_run(const RunRequest& command);

}  // namespace palpate
