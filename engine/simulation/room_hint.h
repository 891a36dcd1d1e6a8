#pragma once

// What to change where a scene has no surface with room for a hand.

#include <string>

#include "engine/simulation/exploration.h"
#include "engine/simulation/surface_path.h"

namespace palpate {

// Options that were found to help, by trial: a size within the workspace at which a path is found,
// or a device that senses two axes; else what has to be different of the scene. wanted: with which
// there is no path. Takes as long as planning a few paths. Not for the haptic thread.
std::string room_hint(const Scene& scene, const RunSetup& setup, const SurfacePathSettings& wanted);

}  // namespace palpate
