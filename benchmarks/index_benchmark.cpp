// Queries of the surface index, compared with Embree's own triangle geometry and CGAL's tree.

#include <array>
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include "benchmarks/medians.h"
#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/trajectories.h"

namespace palpate::bench {
namespace {

// Radius of the first query of a sequence, which has no earlier answer and is not timed.
constexpr double kAcquisitionRadius_m = 0.02;

// From up to 5 mm above the sphere straight down, to below its surface.
constexpr double kSegmentLength_m = 6e-3;

// Radius of the proxy's candidates (haptics/proxy/candidate_cache.cpp), in mean pack diagonals.
constexpr double kGatherPerPackDiagonal = 0.6;

// Tolerance of float answers for coordinates of the sphere's size; a wrong triangle errs by far
// more.
constexpr double kFloatAgreement_m = 1e-6 * kSphereRadius_m;

// Tolerance of double answers by different formulas: a thousand roundings of such a coordinate.
constexpr double kDoubleAgreement_m = 1e3 * 0x1p-53 * kSphereRadius_m;

// Slightly more than the distance to the last answer, which bounds the distance to the next answer.
double tight_radius_m(const Vec3& p, const Vec3& last_nearest) {
  constexpr double kRounding = 1.0 + 1e-12;
  return kRounding * (p - last_nearest).norm();
}
float tight_radius_m(const Eigen::Vector3f& p, const Eigen::Vector3f& last_nearest) {
  constexpr float kRounding = 1.0f + 1e-5f;
  return kRounding * (p - last_nearest).norm();
}

Vec3 segment_into_sphere(const Vec3& p) {
  return -kSegmentLength_m * p.normalized();
}

// The input of a workload: a sphere and a path above it.
struct Setting {
  int subdivisions;
  const std::vector<Vec3>& path_m;
  Caches caches;

  const SurfaceIndex& index() const { return sphere_index(subdivisions); }
  Samples samples() const { return {path_m.size(), caches}; }
};

void indexed_closest_point(benchmark::State& state, const Setting& at) {
  const SurfaceIndex& index = at.index();
  std::optional<SurfacePoint> nearest;
  Vec3 p;
  time_path(
      state, at.samples(),
      [&] { nearest = index.closest_point(at.path_m.front(), kAcquisitionRadius_m); },
      [&](std::size_t n) { p = at.path_m[n]; },
      [&](std::size_t) {
        nearest = index.closest_point(p, tight_radius_m(p, nearest->point_m));
        benchmark::DoNotOptimize(nearest);
      },
      [&](std::size_t) { return nearest ? nullptr : "a closest point was lost"; });
}

void stock_closest_point(benchmark::State& state, const Setting& at) {
  const StockSurface& stock = stock_sphere(at.subdivisions);
  std::optional<StockPoint> nearest;
  Eigen::Vector3f p;
  time_path(
      state, at.samples(),
      [&] {
        nearest = stock.closest_point(at.path_m.front().cast<float>(),
                                      static_cast<float>(kAcquisitionRadius_m));
      },
      [&](std::size_t n) { p = at.path_m[n].cast<float>(); },
      [&](std::size_t) {
        nearest = stock.closest_point(p, tight_radius_m(p, nearest->point_m));
        benchmark::DoNotOptimize(nearest);
      },
      [&](std::size_t) { return nearest ? nullptr : "a closest point was lost"; });
}

void cgal_closest_point(benchmark::State& state, const Setting& at) {
  const CgalSurface& cgal = cgal_sphere(at.subdivisions);
  Vec3 nearest = at.index().closest_point(at.path_m.front(), kAcquisitionRadius_m)->point_m;
  Vec3 p;
  time_path(
      state, at.samples(), [&] { nearest = cgal.closest_point(at.path_m.front(), nearest); },
      [&](std::size_t n) { p = at.path_m[n]; },
      [&](std::size_t) {
        nearest = cgal.closest_point(p, nearest);
        benchmark::DoNotOptimize(nearest);
      },
      [](std::size_t) -> SampleError { return nullptr; });
}

void first_hit(benchmark::State& state, const Setting& at) {
  const SurfaceIndex& index = at.index();
  std::optional<SegmentHit> hit;
  Vec3 p;
  Vec3 d;
  time_path(
      state, at.samples(), [] {},
      [&](std::size_t n) {
        p = at.path_m[n];
        d = segment_into_sphere(p);
      },
      [&](std::size_t) {
        hit = index.first_hit(p, d);
        benchmark::DoNotOptimize(hit);
      },
      [&](std::size_t) { return hit ? nullptr : "a segment through the surface missed it"; });
}

void stock_first_hit(benchmark::State& state, const Setting& at) {
  const StockSurface& stock = stock_sphere(at.subdivisions);
  std::optional<float> hit;
  Eigen::Vector3f p;
  Eigen::Vector3f d;
  time_path(
      state, at.samples(), [] {},
      [&](std::size_t n) {
        p = at.path_m[n].cast<float>();
        d = segment_into_sphere(at.path_m[n]).cast<float>();
      },
      [&](std::size_t) {
        hit = stock.first_hit(p, d);
        benchmark::DoNotOptimize(hit);
      },
      [](std::size_t) -> SampleError { return nullptr; });
}

// Each segment meets the surface once, so any hit is the first hit.
void cgal_first_hit(benchmark::State& state, const Setting& at) {
  const CgalSurface& cgal = cgal_sphere(at.subdivisions);
  std::optional<double> hit;
  Vec3 p;
  Vec3 d;
  time_path(
      state, at.samples(), [] {},
      [&](std::size_t n) {
        p = at.path_m[n];
        d = segment_into_sphere(p);
      },
      [&](std::size_t) {
        hit = cgal.any_hit(p, d);
        benchmark::DoNotOptimize(hit);
      },
      [](std::size_t) -> SampleError { return nullptr; });
}

void packs_near(benchmark::State& state, const Setting& at) {
  const SurfaceIndex& index = at.index();
  const double radius_m = kGatherPerPackDiagonal * index.mean_pack_diagonal_m();
  std::array<std::uint32_t, 256> packs{};
  std::size_t count = 0;
  std::size_t total = 0;
  Vec3 p;
  time_path(
      state, at.samples(), [] {}, [&](std::size_t n) { p = at.path_m[n]; },
      [&](std::size_t) {
        count = index.packs_near(p, radius_m, packs);
        benchmark::DoNotOptimize(packs.data());
      },
      [&](std::size_t) -> SampleError {
        total += count;
        return nullptr;
      });
  state.counters["packs"] =
      benchmark::Counter(static_cast<double>(total), benchmark::Counter::kAvgIterations);
}

bool agrees(double ours_m, double peer_m, double tolerance_m) {
  return std::abs(ours_m - peer_m) <= tolerance_m;
}

// A peer may miss a segment that passes through an edge; Palpate must not.
bool hits_agree(const Setting& at, const Vec3& p) {
  const Vec3 d = segment_into_sphere(p);
  const auto ours = at.index().first_hit(p, d);
  if (!ours) return false;
  const double ours_m = ours->fraction * kSegmentLength_m;
  const auto stock = stock_sphere(at.subdivisions).first_hit(p.cast<float>(), d.cast<float>());
  if (stock && !agrees(ours_m, *stock * kSegmentLength_m, kFloatAgreement_m)) return false;
  if (!kHaveCgal) return true;
  const auto cgal = cgal_sphere(at.subdivisions).any_hit(p, d);
  return !cgal || agrees(ours_m, *cgal * kSegmentLength_m, kDoubleAgreement_m);
}

bool closest_points_agree(const Setting& at, const Vec3& p) {
  const auto ours = at.index().closest_point(p, kAcquisitionRadius_m);
  const auto stock = stock_sphere(at.subdivisions)
                         .closest_point(p.cast<float>(), static_cast<float>(kAcquisitionRadius_m));
  if (!ours || !stock) return false;
  if (!agrees(ours->distance_m, stock->distance_m, kFloatAgreement_m)) return false;
  if (!kHaveCgal) return true;
  // The hint is a vertex, not Palpate's answer, so that CGAL's answer is independent of Palpate's.
  const Vec3 vertex_m = icosphere(0, kSphereRadius_m).positions_m.front();
  const Vec3 cgal = cgal_sphere(at.subdivisions).closest_point(p, vertex_m);
  return agrees(ours->distance_m, (cgal - p).norm(), kDoubleAgreement_m);
}

// Times are compared only if all libraries give the same answers.
bool answers_agree(const Setting& at) {
  constexpr std::size_t kChecks = 100;
  const std::size_t stride = 1 + at.path_m.size() / kChecks;
  for (std::size_t n = 0; n < at.path_m.size(); n += stride) {
    if (!closest_points_agree(at, at.path_m[n]) || !hits_agree(at, at.path_m[n])) return false;
  }
  return true;
}

struct IndexCase {
  const char* name;
  void (*workload)(benchmark::State&, const Setting&);
  HeightSwing swing;
  Caches caches;
  const char* stock_peer;  // the row to compare with, or null
  const char* cgal_peer;
};

// Peers come before the rows that are compared with them.
constexpr IndexCase kCgalCases[] = {
    {"cgal_closest_point", cgal_closest_point, kNear, Caches::kWarm, nullptr, nullptr},
    {"cgal_first_hit", cgal_first_hit, kNear, Caches::kWarm, nullptr, nullptr},
};
constexpr IndexCase kIndexCases[] = {
    {"stock_closest_point", stock_closest_point, kNear, Caches::kWarm, nullptr, nullptr},
    {"stock_closest_point_evicted", stock_closest_point, kNear, Caches::kEvicted, nullptr, nullptr},
    {"stock_first_hit", stock_first_hit, kNear, Caches::kWarm, nullptr, nullptr},
    {"closest_point", indexed_closest_point, kNear, Caches::kWarm, "stock_closest_point",
     "cgal_closest_point"},
    {"closest_point_evicted", indexed_closest_point, kNear, Caches::kEvicted,
     "stock_closest_point_evicted", nullptr},
    {"first_hit", first_hit, kNear, Caches::kWarm, "stock_first_hit", "cgal_first_hit"},
    {"packs_near", packs_near, kOnSurface, Caches::kWarm, nullptr, nullptr},
};

void run(benchmark::State& state, const IndexCase& index_case, int subdivisions,
         std::size_t sample_count) {
  if (!sphere_scene(subdivisions, 0.0)) {
    return state.SkipWithError("the sphere could not be compiled");
  }
  const auto path_m = path_over_sphere(kSphereRadius_m, index_case.swing, sample_count);
  const Setting at{subdivisions, path_m, index_case.caches};
  if (index_case.stock_peer && !answers_agree(at)) {
    return state.SkipWithError("Palpate and its peers give different answers");
  }
  index_case.workload(state, at);
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
  remember_p50(row_name(index_case.name, subdivisions), state);
  const auto compare = [&](const char* counter, const char* peer) {
    if (peer) report_ratio(state, counter, row_name(peer, subdivisions));
  };
  compare("vs_stock_p50", index_case.stock_peer);
  compare("vs_cgal_p50", index_case.cgal_peer);
}

void add(const IndexCase& index_case, int subdivisions, const SampleCounts& counts) {
  const std::size_t count = counts.for_caches(index_case.caches);
  benchmark::RegisterBenchmark(
      row_name(index_case.name, subdivisions).c_str(),
      [=, &index_case](benchmark::State& state) { run(state, index_case, subdivisions, count); })
      ->UseManualTime()
      ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * count));
}

}  // namespace

void register_index_benchmarks(int subdivisions, const SampleCounts& counts) {
  if (kHaveCgal) {
    for (const IndexCase& index_case : kCgalCases) add(index_case, subdivisions, counts);
  }
  for (const IndexCase& index_case : kIndexCases) add(index_case, subdivisions, counts);
}

}  // namespace palpate::bench
