#pragma once

// A hint for scenes that have no surface with enough clearance for a hand.

#include <string>

#include "engine/simulation/exploration.h"
#include "engine/simulation/surface_path.h"

namespace palpate {

// The hint names options that a trial has shown to help: a size within the workspace for which a
// path exists, or a device that senses two axes. If none helps, the hint states how the scene has
// to change. wanted: the settings for which no path exists. The call takes as long as planning a
// few paths. Not for the haptic thread.
std::string clearance_hint(const Scene& scene, const RunSetup& setup,
                           const SurfacePathSettings& wanted);

}  // namespace palpate
