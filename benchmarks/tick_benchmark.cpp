// One full tick of the haptic loop: point proxy, default coupling.

#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/trajectories.h"
#include "haptics/haptic_loop.h"

namespace palpate::bench {
namespace {

// Where the device is before the path begins: the first sample says on which side the proxy is, so
// a path that starts below the surface must come from outside, and at its own speed.
constexpr double kEntryHeight_m = 1e-3;
constexpr int kEntryTicks = 11;

struct TickCase {
  const char* name;
  HeightSwing swing;
  int actuators;  // of 3 sensors
  bool a4;
  double least_contact_share;  // what a run must show to count
  double most_contact_share;
};

constexpr TickCase kCases[] = {
    {"tick_free", kFree, 3, false, 0.0, 0.0},
    {"tick_sliding", kSliding, 3, false, 1.0, 1.0},
    {"tick_tapping", kTapping, 3, false, 0.3, 0.7},
    {"tick_sliding_a4", kSliding, 1, true, 1.0, 1.0},
};

// What the loop did, to prove that the right thing was timed.
struct Tally {
  double ticks = 0.0;
  double contacts = 0.0;
  double iterations = 0.0;
  bool faults = false;

  void add(const TickRecord& record) {
    ticks += 1.0;
    contacts += record.contact ? 1.0 : 0.0;
    iterations += record.solver_iterations;
    faults = faults || record.faults != kFaultNone;
  }
};

Tally time_ticks(benchmark::State& state, const ContactWorld& world, const TickCase& tick_case,
                 const ActuationModel& actuation, const std::vector<Vec3>& path_scene_m) {
  constexpr double kDt_s = 1.0 / kSampleRateHz;
  HapticSettings settings;
  settings.a4.enabled = tick_case.a4;
  std::optional<HapticLoop> loop;
  const TickRecord* record = nullptr;
  Vec3 p_device_m;
  Tally tally;
  // The path is given in the scene frame, so that the proxy meets the same triangles whether A4
  // turns the scene or not.
  const auto aim = [&](const Vec3& p_scene_m) {
    p_device_m = loop->T_device_scene().point(p_scene_m);
  };
  time_path(
      state, path_scene_m.size(),
      [&] {
        loop.emplace(world, actuation, settings);
        const Vec3& first = path_scene_m.front();
        const Vec3 entry = (kSphereRadius_m + kEntryHeight_m) * first.normalized();
        for (int i = 0; i < kEntryTicks; ++i) {
          aim(entry + static_cast<double>(i) / kEntryTicks * (first - entry));
          loop->tick(p_device_m, kDt_s);
        }
        aim(first);
      },
      [&](std::size_t) { record = &loop->tick(p_device_m, kDt_s); },
      [&](std::size_t n) {
        tally.add(*record);
        if (n + 1 < path_scene_m.size()) aim(path_scene_m[n + 1]);
        return SampleError{};
      });
  return tally;
}

void run(benchmark::State& state, const TickCase& tick_case, int subdivisions,
         std::size_t sample_count) {
  const Sphere* target = sphere(subdivisions);
  if (!target) return state.SkipWithError("the sphere could not be compiled");
  const Result<ActuationModel> actuation = ActuationModel::from_counts(3, tick_case.actuators);
  if (!actuation) return state.SkipWithError("the actuation was refused");
  const Tally tally = time_ticks(state, target->scene.world(), tick_case, *actuation,
                                 path_over_sphere(kSphereRadius_m, tick_case.swing, sample_count));
  const double contact_share = tally.contacts / tally.ticks;
  if (tally.faults) return state.SkipWithError("a tick had a fault");
  if (contact_share < tick_case.least_contact_share ||
      contact_share > tick_case.most_contact_share) {
    return state.SkipWithError("the proxy was not in contact as the case says");
  }
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
  state.counters["solver_iterations"] = tally.iterations / tally.ticks;
  state.counters["contact_share"] = contact_share;
}

}  // namespace

void register_tick_benchmarks(int subdivisions, std::size_t sample_count) {
  for (const TickCase& tick_case : kCases) {
    const std::string name =
        std::string(tick_case.name) + "/" + std::to_string(sphere_triangles(subdivisions));
    benchmark::RegisterBenchmark(name.c_str(),
                                 [=, &tick_case](benchmark::State& state) {
                                   run(state, tick_case, subdivisions, sample_count);
                                 })
        ->UseManualTime()
        ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * sample_count));
  }
}

}  // namespace palpate::bench
