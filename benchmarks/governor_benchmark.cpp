// What a tick on a device with motors costs besides the loop: the governor, the heartbeat for the
// guard, and the attribution of late ticks in the haptic thread.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

#include <benchmark/benchmark.h>

#include "benchmarks/registration.h"
#include "engine/devices/monotonic_clock.h"
#include "engine/devices/motor_guard.h"
#include "engine/session/tick_times.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"

namespace palpate::bench {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr std::int64_t kPeriod_ns = 1'000'000;
// A contact that is stable by itself on a device of unknown mechanics (kBareTip).
constexpr double kStiffness_N_per_m = 100.0;
constexpr double kDepth_m = 0.02;

// Motors that keep all rules once the force has grown.
DeviceDescription device_of(int motors, bool moves_motors) {
  DeviceDescription device;
  device.motor_count = motors;
  device.moves_motors = moves_motors;
  device.peak_force_N = 8.0;
  device.workspace_low_m.fill(-0.1);
  device.workspace_high_m.fill(0.1);
  for (std::size_t i = 0; i < device.motors.size(); ++i) {
    device.motors[i].direction_device = {i == 0 ? 1.0 : 0.3, i == 1 ? 1.0 : 0.1,
                                         i == 2 ? 1.0 : 0.0};
    device.motors[i].peak_force_N = 20.0;
    device.motors[i].continuous_force_N = 5.0;
  }
  return device;
}

// Ticks of a governor in real time: a hand that moves in a circle within a spring.
class GovernedTicks {
 public:
  GovernedTicks(const DeviceDescription& device, bool turns)
      : device_(device), turns_(turns), governor_(device, SafetyGovernor::clamp_of(device, {})) {
    for (std::size_t n = 0; n < kSamples; ++n) {
      const double angle =
          2.0 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(kSamples);
      const Vec3 lag_m(-kDepth_m * std::cos(angle), -kDepth_m * std::sin(angle), 0.0);
      positions_m_[n] = {-lag_m.x(), -lag_m.y(), 0.0};
      forces_N_[n] = kStiffness_N_per_m * lag_m;  // in the span of the motors
    }
    while (governor_.status().state != GovernorState::kRuns) tick(0.0);
  }

  const TickRecord& tick(double share = 1.0) {
    const std::size_t n = static_cast<std::size_t>(sample_.sequence++) % kSamples;
    for (std::size_t k = 0; k < 3; ++k) sample_.position_m[k] = share * positions_m_[n][k];
    now_ns_ += kPeriod_ns;
    const DeviceSample& used = governor_.begin_tick(sample_, {kPeriod_s, 0, now_ns_});
    if (turns_) {
      governor_.set_motors(
          std::span(device_.motors).first(static_cast<std::size_t>(device_.motor_count)));
    }
    std::copy_n(used.position_m.data(), 3, record_.device_m);
    record_.faults = kFaultNone;
    record_.contact = 1;
    put(Vec3(share * forces_N_[n]), record_.force_device_N);
    ForceSources sources;
    sources.stiffness_N_per_m = kStiffness_N_per_m;
    sources.lag_m = share * kDepth_m;
    governor_.govern(record_, sources);
    return record_;
  }

 private:
  static constexpr std::size_t kSamples = 1024;
  DeviceDescription device_;
  bool turns_;
  SafetyGovernor governor_;
  DeviceSample sample_;
  TickRecord record_;
  std::int64_t now_ns_ = kPeriod_ns;
  std::array<std::array<double, 3>, kSamples> positions_m_{};
  std::array<Vec3, kSamples> forces_N_{};
};

// What the driver's thread does for the guard with each message (HapiLink::watch_guard, sent). It
// has read the clock for itself.
void beat(MotorGuard& guard, std::int64_t now_ns) {
  benchmark::DoNotOptimize(guard.is_alive(now_ns));
  benchmark::DoNotOptimize(guard.trip_epoch());
  guard.beat(now_ns, now_ns);
}

// A guard that is not armed, of a socket that nobody reads.
class Guard {
 public:
  Guard() {
    GuardSpec spec;
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends_.data()) != 0)
      return;
    spec.descriptor = ends_[0];
    spec.zero_bytes = {0};
    auto guard = MotorGuard::spawn(spec);
    if (guard) guard_ = std::move(*guard);
    if (!guard) problem_ = guard.error().to_string();
  }
  ~Guard() {
    guard_.reset();
    for (const int end : ends_) {
      if (end >= 0) ::close(end);
    }
  }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  MotorGuard* get() const { return guard_.get(); }
  const std::string& problem() const { return problem_; }

 private:
  std::array<int, 2> ends_ = {-1, -1};
  std::unique_ptr<MotorGuard> guard_;
  std::string problem_;
};

struct GovernorCase {
  const char* name;
  int motors = 3;
  bool moves_motors = true;
  bool turns = false;  // the motors turn: they are set in each tick
  bool beats = false;
};

void run_governor(benchmark::State& state, const GovernorCase& governor_case) {
  const Guard guard;
  if (governor_case.beats && guard.get() == nullptr) {
    return state.SkipWithError(guard.problem().c_str());
  }
  GovernedTicks ticks(device_of(governor_case.motors, governor_case.moves_motors),
                      governor_case.turns);
  // The hand presses in, so that the force grows with its way.
  constexpr int kPressing = 2000;
  for (int n = 1; n <= kPressing; ++n) ticks.tick(static_cast<double>(n) / kPressing);
  std::uint32_t faults = kFaultNone, rules = 0;
  std::int64_t now_ns = monotonic_ns();
  for (auto _ : state) {
    const TickRecord& record = ticks.tick();
    faults |= record.faults;
    rules |= record.rules;
    if (governor_case.beats) beat(*guard.get(), ++now_ns);
  }
  if (faults != kFaultNone || rules != 0) state.SkipWithError("a rule of the governor has acted");
}

void run_heartbeat(benchmark::State& state) {
  const Guard guard;
  if (guard.get() == nullptr) return state.SkipWithError(guard.problem().c_str());
  std::int64_t now_ns = monotonic_ns();
  for (auto _ : state) beat(*guard.get(), ++now_ns);
}

// What the haptic thread adds to a tick in order to attribute the late ones.
void run_attribution(benchmark::State& state, bool are_late) {
  TickMeter meter;
  meter.start();
  for (auto _ : state) {
    const std::int64_t start_ns = meter.begin(0);
    meter.end(0, 0, are_late ? 0 : start_ns + kPeriod_ns);
  }
  meter.finish();
  const TickTimes& times = meter.times();
  if (times.cpu.count() != static_cast<std::uint64_t>(state.iterations())) {
    state.SkipWithError("a tick was not counted");
  }
}

}  // namespace

void register_governor_benchmarks() {
  for (const GovernorCase& governor_case :
       {GovernorCase{.name = "simulated_hand", .moves_motors = false},
        GovernorCase{.name = "three_motors"},
        GovernorCase{.name = "two_turning_motors", .motors = 2, .turns = true},
        GovernorCase{.name = "three_turning_motors", .turns = true},
        GovernorCase{.name = "three_motors_with_heartbeat", .beats = true},
        GovernorCase{.name = "two_turning_motors_with_heartbeat",
        .motors = 2,
        .turns = true,
        .beats = true}}) {
    benchmark::RegisterBenchmark(
        (std::string("governor/") + governor_case.name).c_str(),
        [=](benchmark::State& state) { run_governor(state, governor_case); });
  }
  benchmark::RegisterBenchmark("governor/heartbeat", run_heartbeat);
  for (const bool are_late : {false, true}) {
    benchmark::RegisterBenchmark(
        are_late ? "governor/attribution_late" : "governor/attribution",
        [=](benchmark::State& state) { run_attribution(state, are_late); });
  }
}

}  // namespace palpate::bench
