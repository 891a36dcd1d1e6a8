#pragma once

// Replays a recorded device path through a scene. Deterministic; runs on the calling thread, as
// fast as possible.

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/rig/record_keeper.h"
#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

// Runs one tick per device position. path_m: positions in the device frame, metres. passes >= 1:
// the whole path is run this many times, each time by a new loop. The shortest time of each tick is
// kept, because other processes disturb it least. progress: called now and then, between ticks,
// with the share of all passes that is done; may be empty. Returns an error if a node in
// setup.moves does not exist, if check_setup() returns one, or (kOutOfMemory) if there is not
// enough memory for the records of all ticks.
Result<RunRecords> replay(const Scene& scene, const RunSetup& setup,
                          const std::vector<Vec3>& path_m, int passes,
                          const std::function<void(double)>& progress = {});

// The same with measured times (HapticLoop::use_measured_times): lengths_s has the length of each
// tick, > 0 s and of any length. If all lengths are setup.dt_s, every bit is that of the function
// above.
Result<RunRecords> replay(const Scene& scene, const RunSetup& setup,
                          const std::vector<Vec3>& path_m, const std::vector<double>& lengths_s,
                          int passes, const std::function<void(double)>& progress = {});

}  // namespace palpate
