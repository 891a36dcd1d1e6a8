#pragma once

// The damper of a coupling as dampers of a sampled loop.

#include <vector>

#include "engine/devices/sampled_loop.h"
#include "haptics/effects/velocity_estimator.h"

namespace palpate {

// The damper of a coupling whose velocity is estimated in this way, in ticks of equal length: the
// dampers of one entry act together and are exactly this damper. The difference has one entry with
// one damper. The fitted line has one entry with a damper for each window up to its own: the slope
// is a mean of differences, with weights whose sum is 1, some of them below 0. The adaptive method
// chooses one of the windows up to its own in each tick, so that it has an entry for each of them.
std::vector<std::vector<LoopDamper>> coupling_dampers(double damping_Ns_per_m,
                                                      const VelocitySettings& velocity);

}  // namespace palpate
