#include "engine/simulation/soak.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <malloc.h>
#include <memory>
#include <sstream>
#include <thread>
#include <unistd.h>

#include "engine/rig/rig.h"
#include "engine/session/closed_surfaces.h"
#include "engine/session/haptic_thread.h"
#include "engine/simulation/planned_hand.h"
#include "engine/simulation/simulated_device.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kWatchEvery{50};
constexpr double kWarm_s = 1.0;
constexpr double kLap_s = 28.0;  // the time of a usual run

// True if all numbers of the record are finite.
bool is_finite(const TickRecord& record) {
  const auto all_finite = [](const auto& numbers) {
    return std::all_of(std::begin(numbers), std::end(numbers),
                       [](double number) { return std::isfinite(number); });
  };
  return std::isfinite(record.time_s) && all_finite(record.device_m) &&
         all_finite(record.goal_scene_m) && all_finite(record.proxy_scene_m) &&
         all_finite(record.normal_scene) && all_finite(record.full_force_device_N) &&
         all_finite(record.force_device_N) && all_finite(record.q_after_wxyz) &&
         all_finite(record.o_after_m) && std::isfinite(record.alpha_rad) &&
         std::isfinite(record.rotation_rad);
}

class Counter final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    summary_.add(record);
    step_ns_ += record.step_ns;
    if (!is_finite(record)) ++ticks_not_finite_;
  }
  void on_trip(const GovernorTrip& trip) noexcept override { summary_.add(trip); }
  void move_to(SoakRun& run) const {
    run.summary = summary_.finish({});
    run.ticks_not_finite = ticks_not_finite_;
  }
  std::int64_t step_ns() const { return step_ns_; }  // of all ticks

 private:
  SummaryAccumulator summary_;
  std::uint64_t ticks_not_finite_ = 0;
  std::int64_t step_ns_ = 0;
};

std::optional<Error> check_length(double seconds, double dt_s) {
  constexpr double kMostTicks = 9e15;  // counted in a double without rounding
  const double ticks = seconds / dt_s;
  if (seconds >= 2.0 && ticks <= kMostTicks) return std::nullopt;  // false for NaN
  std::ostringstream text;
  text << "is " << seconds << " s; expected at least 2 s";
  return Error{ErrorCode::kInvalidArgument, "", "seconds", text.str(), ""};
}

// Waits for the end of the thread, and measures the memory when the first ticks are over.
void watch(const HapticThread& thread, std::uint64_t ticks, double dt_s,
           const std::function<void(double)>& progress, const StopFlag* stop, SoakRun& run) {
  const auto warm_ticks = static_cast<std::uint64_t>(kWarm_s / dt_s);
  bool is_warm = false;
  while (thread.running() && !(stop != nullptr && stop->requested())) {
    const std::uint64_t done = thread.ticks();
    progress(static_cast<double>(done) / static_cast<double>(ticks));
    if (!is_warm && done >= warm_ticks) {
      is_warm = true;
      run.memory_at_start = ProcessMemory::now();
    }
    std::this_thread::sleep_for(kWatchEvery);
  }
  run.memory_at_end = ProcessMemory::now();
  if (!is_warm) run.memory_at_start = run.memory_at_end;
}

}  // namespace

ProcessMemory ProcessMemory::now() {
  ProcessMemory memory;
  const struct mallinfo2 heap = ::mallinfo2();
  memory.heap = static_cast<std::int64_t>(heap.uordblks + heap.hblkhd);
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);  // fopen() would allocate
  if (file < 0) return memory;
  std::array<char, 128> text{};
  long long pages = 0;
  if (::read(file, text.data(), text.size() - 1) > 0 &&
      std::sscanf(text.data(), "%*d %lld", &pages) == 1) {
    memory.resident = pages * ::sysconf(_SC_PAGESIZE);
  }
  ::close(file);
  return memory;
}

Result<SoakRun> soak(const Scene& scene, const RunSetup& setup, const SoakSettings& settings,
                     const std::function<void(double)>& progress, const StopFlag* stop) {
  if (auto error = check_length(settings.seconds, setup.dt_s)) return *error;
  if (auto error = check_setup(scene, setup)) return *error;
  PlantSettings plant;
  plant.device = setup.device;
  plant.seed = settings.seed;
  if (auto error = check_plant(plant, setup.dt_s)) return *error;
  const int laps = std::max(1, static_cast<int>(std::lround(settings.seconds / kLap_s)));
  auto hand = plan_hand(scene, setup, {settings.seconds, settings.seed, laps});
  if (!hand) return hand.error();
  Counter counter;
  SimulatedDevice device = device_in_hand(plant, setup, *hand->plan,
                                          setup.haptics.initial_pose.point(hand->start_scene_m));
  const auto rig = Rig::create(scene, setup, device, {.observers = {&counter, &device}});
  if (!rig) return rig.error();
  const auto ticks = static_cast<std::uint64_t>(std::llround(settings.seconds / setup.dt_s));
  SoakRun run;
  run.starts_inside = enclosing_object(scene, hand->start_scene_m);
  if (settings.keeps_cpu_times) run.cpu_ns.resize(std::min<std::uint64_t>(ticks, kMostKeptTimes));
  HapticThread thread((*rig)->session(), {1.0 / setup.dt_s, ticks, settings.cpu, run.cpu_ns});
  run.realtime = thread.start();
  watch(thread, ticks, setup.dt_s, progress, stop, run);
  thread.stop();
  counter.move_to(run);
  take_effects((*rig)->loop(), setup.haptics.measures_effects, {counter.step_ns()}, run.summary);
  run.tick_times = thread.times();
  run.interrupted = run.summary.ticks < ticks;
  run.cpu_ns.resize(std::min<std::uint64_t>(run.cpu_ns.size(), run.summary.ticks));
  return run;
}

}  // namespace palpate
