#pragma once

// The scene and the settings of the subcommand `run`, prepared before the hand moves.

#include "engine/cli/run_command.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

struct PreparedRun {
  Scene scene;
  RunSetup setup;  // with a chosen plane height if the user has set none
};

// Loads the scene and chooses the plane of a planar device. With --fit auto, a scene that does not
// fit the workspace is scaled. Returns an error if the scene does not fit; the error names the
// option to change. A person with a device (RunRequest::device) may also explore a part of a scene
// that does not fit.
Result<PreparedRun> prepare_run(const RunRequest& command);

}  // namespace palpate
