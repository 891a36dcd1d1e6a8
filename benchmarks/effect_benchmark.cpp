// The time that each effect adds to a tick: a proxy slides on a sphere with the effect and on the
// same sphere without it.

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/trajectories.h"
#include "engine/accuracy/effect_cases.h"
#include "engine/devices/path_device.h"
#include "engine/rig/rig.h"

namespace palpate::bench {
namespace {

// Larger spheres add no information: the time of an effect does not depend on the size of the mesh.
constexpr int kMostTimedSubdivisions = 8;

// Passes over the path, alternately with and without the effect; the shortest of each kind counts.
constexpr int kPairs = 8;

// Each effect alone, then all effects on the touched surface, then all on an untouched surface.
std::vector<EffectCase> effect_cases() {
  std::vector<EffectCase> cases;
  for (const std::string_view effect : measured_effects()) cases.push_back(only(effect));
  cases.push_back(all_effects());
  cases.push_back(effects_elsewhere());
  return cases;
}

// A loop that repeats one path.
class Slider {
 public:
  Slider(const Scene& scene, const DevicePath& path)
      : scene_(scene), path_(path), setup_(*make_setup({})) {}

  void begin() {
    rig_ = std::move(*Rig::create(scene_, setup_, no_device_));
    for (const Vec3& p_m : path_.lead_in_m) rig_->loop().tick(p_m, kDt_s);
  }
  const TickRecord& tick(std::size_t n) { return rig_->loop().tick(path_.timed_m[n], kDt_s); }

  // The duration of a whole pass.
  double pass_ns() {
    begin();
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t n = 0; n < path_.timed_m.size(); ++n) tick(n);
    return static_cast<double>(nanoseconds_since(start));
  }

  // The share of ticks in which the effect was active.
  double active_share(std::string_view effect) const {
    const EffectCounters* counters = rig_->loop().effect_counters();
    const auto types = compiled_effects();
    for (std::size_t i = 0; counters && i < types.size(); ++i) {
      if (types[i].name != effect) continue;
      return static_cast<double>(counters->ticks[i]) /
             static_cast<double>(path_.lead_in_m.size() + path_.timed_m.size());
    }
    return 0.0;
  }

 private:
  const Scene& scene_;
  const DevicePath& path_;
  RunSetup setup_;  // a point, three actuators, no A4
  PathDevice no_device_{{}};
  std::unique_ptr<Rig> rig_;
};

void run(benchmark::State& state, const EffectCase& effect_case, int subdivisions,
         const SampleCounts& counts) {
  const auto with = effect_scene(subdivisions, kSphereRadius_m, effect_case);
  const auto without = effect_scene(subdivisions, kSphereRadius_m, without_effects(effect_case));
  if (!with || !without) return state.SkipWithError("the scene could not be compiled");
  const DevicePath path = entered_path_over_sphere(kSphereRadius_m, kSliding, counts.warm);
  Slider slider(*with, path);
  Slider plain(*without, path);
  const TickRecord* record = nullptr;
  bool had_fault = false;
  time_path(
      state, {path.timed_m.size(), Caches::kWarm}, [&] { slider.begin(); }, [](std::size_t) {},
      [&](std::size_t n) { record = &slider.tick(n); },
      [&](std::size_t) {
        had_fault = had_fault || record->faults != kFaultNone || !record->contact;
        return SampleError{};
      });
  if (had_fault) return state.SkipWithError("a tick had a fault or no contact");
  double with_ns = std::numeric_limits<double>::infinity();
  double plain_ns = with_ns;
  for (int i = 0; i < kPairs; ++i) {
    with_ns = std::min(with_ns, slider.pass_ns());
    plain_ns = std::min(plain_ns, plain.pass_ns());
  }
  const auto ticks = static_cast<double>(path.timed_m.size());
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
  state.counters["tick_ns"] = with_ns / ticks;
  state.counters["marginal_ns"] = (with_ns - plain_ns) / ticks;
  state.counters["vs_bare"] = with_ns / plain_ns;
  if (effect_case.effects.size() == 1) {
    const double active = slider.active_share(effect_case.name);
    state.counters["felt_share"] = active;
    // Taps are rare on this path; all other effects are active throughout.
    if (active == 0.0 && !effect_case.has("restitution")) {
      return state.SkipWithError("the effect was never active");
    }
  }
}

}  // namespace

void register_effect_benchmarks(int subdivisions, const SampleCounts& counts) {
  if (subdivisions > kMostTimedSubdivisions) return;
  for (const EffectCase& effect_case : effect_cases()) {
    const std::string name = "tick_sliding_with_" + effect_case.name;
    benchmark::RegisterBenchmark(
        row_name(name, subdivisions).c_str(),
        [=](benchmark::State& state) { run(state, effect_case, subdivisions, counts); })
        ->UseManualTime()
        ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * counts.warm));
  }
}

}  // namespace palpate::bench
