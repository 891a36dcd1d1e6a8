#include "engine/session/replay.h"

#include <algorithm>
#include <chrono>
#include <numeric>

namespace palpate {

namespace {

// As below, but it may throw where there is no memory.
Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, int passes, MemoryLedger& ledger) {
  if (auto error = check_setup(scene, setup)) return *error;
  ledger.begin("recording the ticks");
  const std::uint64_t ticks = path_m.size();
  if (auto error = ledger.take(ticks * (sizeof(TickRecord) + sizeof(std::int64_t)))) return *error;
  ReplayResult result;
  result.records.resize(path_m.size());
  result.steps_ns.resize(path_m.size());
  SummaryAccumulator summary;
  RunSummary of_first_pass;  // what it did, without the times that are kept of all passes
  for (int pass = 0; pass < passes; ++pass) {
    HapticLoop loop(scene.world(), setup.actuation, setup.haptics);
    auto mover = SteadyMotions::create(scene, setup.moves);
    if (!mover) return mover.error();
    double time_s = 0.0;  // a sum, as a session has it: n dt has other bits
    for (std::size_t n = 0; n < path_m.size(); ++n) {
      mover->move_bodies(time_s, loop);
      const auto start = std::chrono::steady_clock::now();
      const TickRecord& record = loop.tick(path_m[n], setup.dt_s);
      const std::chrono::nanoseconds step = std::chrono::steady_clock::now() - start;
      time_s += setup.dt_s;
      if (pass == 0) {
        result.records[n] = record;
        result.steps_ns[n] = step.count();
        summary.add(record);
      } else {
        result.steps_ns[n] = std::min<std::int64_t>(result.steps_ns[n], step.count());
      }
    }
    if (pass > 0) continue;
    const auto all_ns =
        std::accumulate(result.steps_ns.begin(), result.steps_ns.end(), std::int64_t{0});
    take_effects(loop, setup.haptics.measures_effects, all_ns, of_first_pass);
  }
  result.summary = summary.finish(result.steps_ns);
  result.summary.effect_ticks = of_first_pass.effect_ticks;
  result.summary.effect_time_shares = of_first_pass.effect_time_shares;
  return result;
}

}  // namespace

Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, int passes) {
  MemoryLedger ledger;
  return or_out_of_memory(ledger, [&] { return replay(scene, setup, path_m, passes, ledger); });
}

}  // namespace palpate
