#pragma once

// Ticks of a haptic loop along a path, timed one by one, with a tally that shows whether they are
// valid.

#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/percentiles.h"
#include "engine/accuracy/sphere_paths.h"
#include "haptics/haptic_loop.h"

namespace palpate::bench {

// Events of the timed ticks, to verify that the intended case was timed.
struct Tally {
  double ticks = 0.0;
  double contacts = 0.0;
  double iterations = 0.0;
  double capped = 0.0;
  bool other_faults = false;
  std::vector<Vec3> proxies_scene_m;  // of the first pass

  double contact_share() const { return contacts / ticks; }
  double capped_share() const { return capped / ticks; }
};

// Times every tick of a path. The path is in the scene frame, so that the proxy meets the same
// triangles with and without A4. Each pass begins with a new loop. Reports percentiles,
// solver_iterations, contact_share and capped_share.
Tally time_ticks(benchmark::State& state, const ContactWorld& world,
                 const ActuationModel& actuation, const HapticSettings& settings,
                 const DevicePath& path, Caches caches);

}  // namespace palpate::bench
