#pragma once

// The stiffness of the surfaces while a page of `view` changes it, on a device that pushes.

#include <memory>

#include "engine/cli/prepared_run.h"
#include "engine/cli/run_stiffness.h"
#include "engine/viewer/wall_judge.h"

namespace palpate {

// Judges all surfaces as choose_stiffness() does, which has chosen this stiffness for this device
// and this run. What no damping holds is refused, unless the person has allowed it
// (--allow-unstable). The judge tells the zone when it changes. All references must outlive it.
std::unique_ptr<WallJudge> make_wall_judge(const DeviceDescription& device,
                                           const PreparedRun& prepared, const RunStiffness& chosen);

}  // namespace palpate
