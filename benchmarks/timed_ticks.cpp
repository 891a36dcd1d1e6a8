#include "benchmarks/timed_ticks.h"

#include <memory>
#include <utility>

#include "benchmarks/trajectories.h"
#include "engine/devices/path_device.h"
#include "engine/rig/rig.h"
#include "haptics/record_vectors.h"

namespace palpate::bench {
namespace {

void add(const TickRecord& record, Tally& tally) {
  tally.ticks += 1.0;
  tally.contacts += record.contact ? 1.0 : 0.0;
  tally.iterations += record.iterations;
  tally.capped += (record.faults & kFaultSolverCapped) != 0 ? 1.0 : 0.0;
  tally.other_faults = tally.other_faults || (record.faults & ~kFaultSolverCapped) != 0;
}

}  // namespace

Tally time_ticks(benchmark::State& state, const ContactWorld& world,
                 const ActuationModel& actuation, const HapticSettings& settings,
                 const DevicePath& path, Caches caches) {
  const RunSetup setup{actuation, settings, kDt_s, {}};
  PathDevice no_device({});
  std::unique_ptr<Rig> rig;
  const TickRecord* record = nullptr;
  Vec3 next_device_m;
  Vec3 p_device_m;
  Tally tally;
  // Computed before the caches are evicted, because it reads the pose of the loop.
  const auto aim = [&](const Vec3& p_scene_m) {
    next_device_m = rig->loop().T_device_scene().point(p_scene_m);
  };
  time_path(
      state, {path.timed_m.size(), caches},
      [&] {
        auto made = Rig::create(world, setup, no_device);
        rig = std::move(*made);
        for (const Vec3& p_scene_m : path.lead_in_m) {
          aim(p_scene_m);
          rig->loop().tick(next_device_m, kDt_s);
        }
        aim(path.timed_m.front());
      },
      [&](std::size_t) { p_device_m = next_device_m; },
      [&](std::size_t) { record = &rig->loop().tick(p_device_m, kDt_s); },
      [&](std::size_t n) {
        add(*record, tally);
        if (tally.proxies_scene_m.size() < path.timed_m.size()) {
          tally.proxies_scene_m.push_back(vec3(record->proxy_scene_m));
        }
        if (n + 1 < path.timed_m.size()) aim(path.timed_m[n + 1]);
        return SampleError{};
      });
  state.counters["solver_iterations"] = tally.iterations / tally.ticks;
  state.counters["contact_share"] = tally.contact_share();
  state.counters["capped_share"] = tally.capped_share();
  return tally;
}

}  // namespace palpate::bench
