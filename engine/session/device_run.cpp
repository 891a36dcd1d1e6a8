#include "engine/session/device_run.h"

#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>
#include <utility>

#include "engine/scene/memory_budget.h"
#include "engine/session/guarded_run.h"
#include "engine/session/node_motions.h"

namespace palpate {
namespace {

// One hour at 1 kHz is below this limit.
constexpr double kMostDeviceTicks = 4e6;

constexpr auto kLookEvery = std::chrono::milliseconds(20);

// Records every tick in memory allocated before the start.
class DeviceRecorder final : public TickObserver {
 public:
  explicit DeviceRecorder(std::size_t ticks) : records_(ticks) {}
  void on_tick(const TickRecord& record) noexcept override {
    if (count_ < records_.size()) records_[count_++] = record;
    summary_.add(record);
  }
  void on_trip(const GovernorTrip& trip) noexcept override { summary_.add(trip); }
  // Call it after the last tick.
  void move_to(DeviceRun& run) {
    records_.resize(count_);
    run.records = std::move(records_);
    run.summary = summary_.finish(steps_of(run.records));
  }

 private:
  std::vector<TickRecord> records_;
  std::size_t count_ = 0;
  SummaryAccumulator summary_;
};

// Comparisons are false for NaN.
std::optional<Error> check_length(double seconds, double dt_s) {
  const double ticks = seconds / dt_s;
  if (ticks >= 1.0 && ticks <= kMostDeviceTicks) return std::nullopt;
  std::ostringstream text;
  text << "multiplied by `RunSettings::rate_Hz` gives " << ticks << " ticks; expected 1 to "
       << kMostDeviceTicks;
  return invalid_argument("seconds", text.str(), "choose a shorter run or another rate");
}

std::optional<Error> take_record_memory(const DeviceRunSettings& settings, std::uint64_t ticks,
                                        MemoryLedger& ledger) {
  ledger = MemoryLedger(memory_limit(settings.max_memory_bytes));
  ledger.advise("choose a shorter run");
  ledger.begin("preparing the run");
  if (auto error = ledger.take(settings.taken_memory_bytes)) return error;
  ledger.begin("recording the ticks", "seconds");
  return ledger.take(ticks * (sizeof(TickRecord) + sizeof(std::int64_t)));
}

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
  if (auto error = check_length(settings.seconds, setup.dt_s)) return *error;
  if (auto error = check_setup(scene, setup)) return *error;
  const auto ticks = static_cast<std::uint64_t>(std::llround(settings.seconds / setup.dt_s));
  if (auto error = take_record_memory(settings, ticks, ledger)) return *error;
  auto mover = SteadyMotions::create(scene, setup.moves);
  if (!mover) return mover.error();
  DeviceRecorder recorder(ticks);
  StartInside start_inside(scene, settings.stays_inside);
  HapticLoop loop(scene.world(), setup.actuation, setup.haptics);
  HapticSession session(loop, device,
                        {.changes = {&*mover, &start_inside},
                         .observers = {&recorder},
                         .max_force_N = setup.max_force_N,
                         .takes_motors = settings.takes_motors,
                         .sink = settings.sink});
  GuardedRun run(device, session,
                 {.thread = {1.0 / setup.dt_s, ticks, settings.cpu},
                  .has_guard = settings.has_guard,
                  .without_realtime = settings.without_realtime});
  if (auto error = run.start()) return *error;
  StartInsideNews news(start_inside);
  const auto look = [&] {
    const auto status = news.look();
    if (status && settings.on_start_inside) settings.on_start_inside(*status);
  };
  wait_for_end(run, session, ticks, progress, stop, look);
  run.stop();
  look();
  DeviceRun done;
  done.start_inside = start_inside.status();
  recorder.move_to(done);
  take_effects(loop, setup.haptics.measures_effects, steps_of(done.records), done.summary);
  session.latest(done.governor);
  done.interrupted = done.records.size() < ticks && done.governor.trips == 0;
  done.missed_deadlines = run.thread().missed_deadlines();
  done.tick_times = run.thread().times();
  done.has_fifo = run.has_fifo();
  done.health = device.health();
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
