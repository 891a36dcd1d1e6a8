#pragma once

// A recorded device path through a scene: deterministic, no thread, as fast as it goes.

#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/session/run_summary.h"
#include "geometry/base/result.h"

namespace palpate {

struct ReplayResult {
  std::vector<TickRecord> records;  // each tick's step_ns is its shortest over the passes
  RunSummary summary;
};

// One tick per device position (device frame, metres). passes >= 1: repeats the whole path from a
// fresh start and keeps each tick's shortest time, the one least disturbed by the machine.
// An error if a node that is to move is not there, as of check_setup(), or (kOutOfMemory) if there
// is not enough memory for a record of each tick.
Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, int passes);

}  // namespace palpate
