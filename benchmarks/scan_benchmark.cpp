// A hand that explores scans of a machine's housing, with features that smooth spheres lack.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "benchmarks/compiled_mesh.h"
#include "benchmarks/contact_walk.h"
#include "benchmarks/last_built.h"
#include "benchmarks/registration.h"
#include "benchmarks/scan_mesh.h"
#include "benchmarks/scanned_body.h"
#include "benchmarks/timed_ticks.h"
#include "benchmarks/trajectories.h"

namespace palpate::bench {
namespace {

// Scans measured together with the spheres of these subdivisions.
struct ScanSize {
  int subdivisions;
  const char* name;  // approximate number of triangles
  double cell_m;
};
constexpr ScanSize kSizes[] = {
    {5, "100k", 2.8e-3}, {7, "500k", 1.5e-3}, {8, "1.6M", 0.87e-3}, {9, "6M", 0.455e-3}};

struct ScanCase {
  const char* name;
  double proxy_radius_m;
  Caches caches;
};
constexpr ScanCase kScanCases[] = {
    {"scan_point", 0.0, Caches::kWarm},
    {"scan_point_evicted", 0.0, Caches::kEvicted},
    {"scan_sphere_0.1mm", 1e-4, Caches::kWarm},
    {"scan_sphere_0.1mm_evicted", 1e-4, Caches::kEvicted},
    {"scan_sphere_1mm", 1e-3, Caches::kWarm},
    {"scan_sphere_1mm_evicted", 1e-3, Caches::kEvicted},
    {"scan_sphere_5mm", 5e-3, Caches::kWarm},
    {"scan_sphere_5mm_evicted", 5e-3, Caches::kEvicted},
};

// This walk passes over and between fins.
constexpr std::uint64_t kWalkSeed = 4;

// Up to 2 mm inside the surface, and briefly above it twice a second.
constexpr HeightSwing kPressing{-2e-3, 2e-4, 0.5};

// Share of ticks: through holes of the scan and lost fins the hand passes without contact.
constexpr double kLeastContact = 0.25;

const Scene* scan_scene(double cell_m, double proxy_radius_m) {
  static LastBuilt<double, TriangleMesh> last_mesh;
  static LastBuilt<std::pair<double, double>, Scene> last_scene;
  const std::optional<Scene>& scene = last_scene.get({cell_m, proxy_radius_m}, [&] {
    const auto scan = [&] { return std::optional(scan_of(ScannedBody(), cell_m)); };
    return compile_mesh("scan", *last_mesh.get(cell_m, scan), proxy_radius_m);
  });
  return scene ? &*scene : nullptr;
}

// Fewer samples for the largest sphere, whose ticks are slow.
std::size_t samples_of(const ScanCase& scan_case, const SampleCounts& counts) {
  return scan_case.proxy_radius_m > 1e-3 ? counts.fewer() : counts.for_caches(scan_case.caches);
}

void run(benchmark::State& state, const ScanSize& size, const ScanCase& scan_case,
         const SampleCounts& counts) {
  const Scene* scene = scan_scene(size.cell_m, scan_case.proxy_radius_m);
  if (!scene) return state.SkipWithError("the scan could not be compiled");
  const Result<ActuationModel> actuation = ActuationModel::from_counts(3, 3);
  if (!actuation) return state.SkipWithError("the actuation was refused");
  const WalkStyle style{
      .proxy_radius_m = scan_case.proxy_radius_m, .swing = kPressing, .seed = kWalkSeed};
  const DevicePath path = contact_walk(ScannedBody(), style, samples_of(scan_case, counts));
  HapticSettings settings;
  settings.god_object.radius_m = scan_case.proxy_radius_m;
  settings.a4.enabled = false;
  const Tally tally =
      time_ticks(state, scene->world(), *actuation, settings, path, scan_case.caches);
  if (tally.other_faults) return state.SkipWithError("a tick had a fault");
  if (tally.contact_share() < kLeastContact) {
    return state.SkipWithError("the hand was in contact too rarely");
  }
  state.counters["triangles"] = static_cast<double>(scene->statistics().instanced_triangles);
}

}  // namespace

void register_scan_benchmarks(int subdivisions, const SampleCounts& counts) {
  for (const ScanSize& size : kSizes) {
    if (size.subdivisions != subdivisions) continue;
    for (const ScanCase& scan_case : kScanCases) {
      benchmark::RegisterBenchmark((std::string(scan_case.name) + "/" + size.name).c_str(),
                                   [&size, &scan_case, counts](benchmark::State& state) {
                                     run(state, size, scan_case, counts);
                                   })
          ->UseManualTime()
          ->Iterations(
              static_cast<benchmark::IterationCount>(kRepeats * samples_of(scan_case, counts)));
    }
  }
}

}  // namespace palpate::bench
