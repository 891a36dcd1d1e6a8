#include "engine/rig/device_run.h"

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "engine/rig/rig.h"
#include "engine/session/guarded_run.h"

namespace palpate {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(20);

bool has_tripped(const HapticSession& session) {
  GovernorStatus status;
  return session.latest(status) && status.trips > 0;
}

// Returns when the run must end.
void wait_for_end(const GuardedRun& run, const HapticSession& session, std::uint64_t ticks,
                  const std::function<void(double)>& progress, const StopFlag* stop,
                  const std::function<void()>& look) {
  const auto is_stopped = [stop] { return stop != nullptr && stop->requested(); };
  while (run.thread().running() && !is_stopped() && !has_tripped(session)) {
    progress(static_cast<double>(run.thread().ticks()) / static_cast<double>(ticks));
    look();
    std::this_thread::sleep_for(kLookEvery);
  }
}

// As the public run_device(), but throws std::bad_alloc if memory runs out.
Result<DeviceRun> run_device(const Scene& scene, const RunSetup& setup, GuardableDevice& device,
                             const DeviceRunSettings& settings,
                             const std::function<void(double)>& progress, const StopFlag* stop,
                             MemoryLedger& ledger) {
  const auto ticks = kept_ticks(settings.seconds, setup.dt_s);
  if (!ticks) return ticks.error();
  if (auto error = check_setup(scene, setup)) return *error;
  if (auto error = take_run_memory(settings.max_memory_bytes, settings.taken_memory_bytes,
                                   "choose a shorter run", *ticks, ledger)) {
    return *error;
  }
  const auto rig = Rig::create(scene, setup, device,
                               {.keeper = std::make_unique<RecordKeeper>(*ticks),
                                .sink = settings.sink,
                                .takes_motors = settings.takes_motors,
                                .stays_inside = settings.stays_inside});
  if (!rig) return rig.error();
  HapticSession& session = (*rig)->session();
  GuardedRun run(device, session,
                 {.thread = {1.0 / setup.dt_s, *ticks, settings.cpu},
                  .has_guard = settings.has_guard,
                  .without_realtime = settings.without_realtime});
  if (auto error = run.start()) return *error;
  StartInsideNews news((*rig)->start_inside());
  const auto look = [&] {
    const auto status = news.look();
    if (status && settings.on_start_inside) settings.on_start_inside(*status);
  };
  wait_for_end(run, session, *ticks, progress, stop, look);
  run.stop();
  look();
  DeviceRun done;
  done.start_inside = (*rig)->start_inside().status();
  RunRecords kept = (*rig)->take_keeper()->finish();
  done.records = std::move(kept.records);
  done.summary = kept.summary;
  session.latest(done.governor);
  done.interrupted = done.records.size() < *ticks && done.governor.trips == 0;
  done.missed_deadlines = run.thread().missed_deadlines();
  done.tick_times = run.thread().times();
  done.has_fifo = run.has_fifo();
  done.health = device.health();
  done.line = device.line_rate();
  done.warnings = run.warnings();
  return done;
}

}  // namespace

Result<DeviceRun> run_device(const Scene& scene, const RunSetup& setup, GuardableDevice& device,
                             const DeviceRunSettings& settings,
                             const std::function<void(double)>& progress, const StopFlag* stop) {
  MemoryLedger ledger;
  return or_out_of_memory(
      ledger, [&] { return run_device(scene, setup, device, settings, progress, stop, ledger); });
}

}  // namespace palpate
