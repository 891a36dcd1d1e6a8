// One full tick of the haptic loop: default accuracy, default coupling.

#include <string>

#include <benchmark/benchmark.h>

#include "benchmarks/medians.h"
#include "benchmarks/proxy_neighbours.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/timed_ticks.h"
#include "benchmarks/trajectories.h"
#include "geometry/index/simd.h"

namespace palpate::bench {
namespace {

constexpr double kSphereProxyRadius_m = 1e-3;
constexpr std::size_t kFirstTicks = 50;       // ticks of a loop that starts at the centre
constexpr double kWander_m = 10.0 * kStep_m;  // range about the centre: several triangles' width
constexpr double kTeleportRadiusPerRadius = 1.5;   // so that most jumps cross the surface
constexpr double kLongestTeleportPerRadius = 1.9;  // a jump beyond the scene's size, 2, is a fault

// The share of ticks in contact that a valid run must have.
struct ContactShare {
  double least;
  double most;
};
constexpr ContactShare kNever{0.0, 0.0};
constexpr ContactShare kAlways{1.0, 1.0};
constexpr ContactShare kNowAndThen{0.3, 0.7};
constexpr ContactShare kAny{0.0, 1.0};

struct TickCase {
  const char* name;
  DevicePath (*path)(const TickCase&, const SampleCounts&);
  ContactShare contact;
  Caches caches = Caches::kWarm;
  double proxy_radius_m = 0.0;
  int actuators = 3;           // the device has 3 sensors; with fewer than 3 actuators A4 is on
  bool may_be_capped = false;  // slow inputs may reach the limits of a tick
  const char* stock_peer = nullptr;  // the row of an index peer to compare with
  Accuracy accuracy = Accuracy::balanced();
  SimdLevel simd = SimdLevel::kAvx512;  // at most
};

// A path along the sphere; heights are above the proxy's centre in contact.
template <const HeightSwing& kSwing>
DevicePath along_sphere(const TickCase& tick_case, const SampleCounts& counts) {
  return entered_path_over_sphere(kSphereRadius_m + tick_case.proxy_radius_m, kSwing,
                                  counts.for_caches(tick_case.caches));
}

DevicePath starting_at_centre(const TickCase&, const SampleCounts&) {
  return {{}, path_about_centre(kStep_m, kFirstTicks)};
}

DevicePath pressed_to_centre(const TickCase&, const SampleCounts& counts) {
  return {path_to_centre(kSphereRadius_m), path_about_centre(kWander_m, counts.fewer())};
}

DevicePath teleports(const TickCase&, const SampleCounts& counts) {
  return {{},
          random_teleports(kTeleportRadiusPerRadius * kSphereRadius_m,
                           kLongestTeleportPerRadius * kSphereRadius_m, counts.fewer())};
}

// The sphere proxy is last, because it uses another index.
constexpr TickCase kTickCases[] = {
    {.name = "tick_free", .path = along_sphere<kFree>, .contact = kNever},
    {.name = "tick_sliding",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .stock_peer = "stock_closest_point"},
    {.name = "tick_sliding_avx2",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .simd = SimdLevel::kAvx2},
    {.name = "tick_sliding_sse2",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .simd = SimdLevel::kBaseline},
    {.name = "tick_sliding_fast",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .may_be_capped = true,
     .accuracy = Accuracy::fast()},
    {.name = "tick_sliding_float",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .may_be_capped = true,
     .accuracy = {.narrow_phase = NarrowPhase::kFloat}},
    {.name = "tick_sliding_exact",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .accuracy = Accuracy::exact()},
    {.name = "tick_tapping", .path = along_sphere<kTapping>, .contact = kNowAndThen},
    {.name = "tick_sliding_a4", .path = along_sphere<kSliding>, .contact = kAlways, .actuators = 1},
    {.name = "tick_free_evicted",
     .path = along_sphere<kFree>,
     .contact = kNever,
     .caches = Caches::kEvicted},
    {.name = "tick_sliding_evicted",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .caches = Caches::kEvicted,
     .stock_peer = "stock_closest_point_evicted"},
    {.name = "tick_tapping_evicted",
     .path = along_sphere<kTapping>,
     .contact = kNowAndThen,
     .caches = Caches::kEvicted},
    {.name = "tick_centre", .path = starting_at_centre, .contact = kNever, .may_be_capped = true},
    {.name = "tick_centre_pressed",
     .path = pressed_to_centre,
     .contact = kAlways,
     .may_be_capped = true},
    {.name = "tick_teleport", .path = teleports, .contact = kAny, .may_be_capped = true},
    {.name = "tick_sphere_sliding",
     .path = along_sphere<kSliding>,
     .contact = kAlways,
     .proxy_radius_m = kSphereProxyRadius_m},
};

// Null if the run matched the case.
SampleError what_went_wrong(const TickCase& tick_case, const Tally& tally) {
  if (tally.other_faults) return "a tick had a fault";
  if (tally.capped > 0.0 && !tick_case.may_be_capped) return "a tick reached a limit of the solver";
  const bool matches = tally.contact_share() >= tick_case.contact.least &&
                       tally.contact_share() <= tick_case.contact.most;
  return matches ? nullptr : "the share of ticks in contact does not match the case";
}

void run(benchmark::State& state, const TickCase& tick_case, int subdivisions,
         const SampleCounts& counts) {
  const Scene* scene = sphere_scene(subdivisions, tick_case.proxy_radius_m);
  if (!scene) return state.SkipWithError("the sphere could not be compiled");
  const Result<ActuationModel> actuation = ActuationModel::from_counts(3, tick_case.actuators);
  if (!actuation) return state.SkipWithError("the actuation was refused");
  HapticSettings settings;
  settings.god_object.radius_m = tick_case.proxy_radius_m;
  settings.god_object.accuracy = tick_case.accuracy;
  settings.a4.enabled = tick_case.actuators < 3;
  limit_simd_level(tick_case.simd);
  const Tally tally = time_ticks(state, scene->world(), *actuation, settings,
                                 tick_case.path(tick_case, counts), tick_case.caches);
  limit_simd_level(SimdLevel::kAvx512);
  if (const SampleError error = what_went_wrong(tick_case, tally)) {
    return state.SkipWithError(error);
  }
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
  if (tick_case.proxy_radius_m > 0.0) {
    const ProxyNeighbours mean =
        mean_proxy_neighbours(*scene, tally.proxies_scene_m, tick_case.proxy_radius_m, kStep_m);
    state.counters["triangles_under_proxy"] = mean.under;
    state.counters["triangles_in_reach"] = mean.in_reach;
  }
  remember_p50(row_name(tick_case.name, subdivisions), state);
  if (tick_case.stock_peer) {
    report_ratio(state, "vs_stock_p50", row_name(tick_case.stock_peer, subdivisions));
  }
}

}  // namespace

void register_tick_benchmarks(int subdivisions, const SampleCounts& counts) {
  for (const TickCase& tick_case : kTickCases) {
    const std::size_t samples = tick_case.path(tick_case, counts).timed_m.size();
    benchmark::RegisterBenchmark(
        row_name(tick_case.name, subdivisions).c_str(),
        [=, &tick_case](benchmark::State& state) { run(state, tick_case, subdivisions, counts); })
        ->UseManualTime()
        ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * samples));
  }
}

}  // namespace palpate::bench
