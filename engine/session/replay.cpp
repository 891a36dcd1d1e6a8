#include "engine/session/replay.h"

#include <algorithm>

#include "engine/devices/path_device.h"
#include "engine/session/haptic_session.h"
#include "geometry/base/memory_ledger.h"

namespace palpate {
namespace {

// Keeps the records of the first pass. A later pass only replaces the time of a tick by a shorter
// one.
class Keeper final : public TickObserver {
 public:
  // summary: null for a later pass.
  Keeper(std::vector<TickRecord>& records, SummaryAccumulator* summary)
      : records_(records), summary_(summary) {}
  void on_tick(const TickRecord& record) noexcept override {
    TickRecord& kept = records_[record.tick];
    if (summary_) {
      kept = record;
      summary_->add(record);
    } else {
      kept.step_ns = std::min(kept.step_ns, record.step_ns);
    }
  }

 private:
  std::vector<TickRecord>& records_;
  SummaryAccumulator* summary_;
};

constexpr std::size_t kTicksBetweenProgress = 1024;

// The same as the public replay(), but throws if an allocation fails. lengths_s: null if every tick
// has the length setup.dt_s.
Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, const std::vector<double>* lengths_s,
                            int passes, const std::function<void(double)>& progress,
                            MemoryLedger& ledger) {
  if (auto error = check_setup(scene, setup)) return *error;
  ledger.begin("recording the ticks");
  const std::uint64_t ticks = path_m.size();
  if (auto error = ledger.take(ticks * (sizeof(TickRecord) + sizeof(std::int64_t)))) return *error;
  ReplayResult result;
  result.records.resize(path_m.size());
  SummaryAccumulator summary;
  RunSummary of_first_pass;  // effects of the first pass; step times come from all passes
  for (int pass = 0; pass < passes; ++pass) {
    HapticLoop loop(scene.world(), setup.actuation, setup.haptics);
    if (lengths_s) loop.use_measured_times();
    auto mover = SteadyMotions::create(scene, setup.moves);
    if (!mover) return mover.error();
    PathDevice device(path_m);
    Keeper keeper(result.records, pass == 0 ? &summary : nullptr);
    HapticSession session(
        loop, device,
        {.changes = {&*mover}, .observers = {&keeper}, .max_force_N = setup.max_force_N});
    session.start();
    for (std::size_t n = 0; n < path_m.size(); ++n) {
      if (progress && n % kTicksBetweenProgress == 0) {
        const double of_pass = static_cast<double>(n) / static_cast<double>(path_m.size());
        progress((pass + of_pass) / passes);
      }
      session.tick(lengths_s ? (*lengths_s)[n] : setup.dt_s);
    }
    if (pass == 0) {
      take_effects(loop, setup.haptics.measures_effects, steps_of(result.records), of_first_pass);
    }
  }
  result.summary = summary.finish(steps_of(result.records));
  result.summary.effect_ticks = of_first_pass.effect_ticks;
  result.summary.effect_time_shares = of_first_pass.effect_time_shares;
  return result;
}

}  // namespace

Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, int passes,
                            const std::function<void(double)>& progress) {
  MemoryLedger ledger;
  return or_out_of_memory(
      ledger, [&] { return replay(scene, setup, path_m, nullptr, passes, progress, ledger); });
}

Result<ReplayResult> replay(const Scene& scene, const RunSetup& setup,
                            const std::vector<Vec3>& path_m, const std::vector<double>& lengths_s,
                            int passes, const std::function<void(double)>& progress) {
  MemoryLedger ledger;
  return or_out_of_memory(
      ledger, [&] { return replay(scene, setup, path_m, &lengths_s, passes, progress, ledger); });
}

}  // namespace palpate
