// Queries of the surface index, with Embree's own triangle geometry beside them.

#include <array>
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/trajectories.h"

namespace palpate::bench {
namespace {

// The first query of a sequence, which is not timed, knows no earlier answer.
constexpr double kAcquisitionRadius_m = 0.02;

// From up to 5 mm above the sphere straight to below it.
constexpr double kSegmentLength_m = 6e-3;

// What the proxy gathers around itself (haptics/segment_tracer.cpp), in mean pack diagonals.
constexpr double kGatherPerPackDiagonal = 0.3;

// Float answers on coordinates of the sphere's size; a wrong triangle is off by much more.
constexpr double kFloatAgreement_m = 1e-6 * kSphereRadius_m;

// A little more than the distance to the last answer, which bounds the distance to the next.
double tight_radius_m(const Vec3& p, const Vec3& last_nearest) {
  constexpr double kRounding = 1.0 + 1e-12;
  return kRounding * (p - last_nearest).norm();
}
float tight_radius_m(const Eigen::Vector3f& p, const Eigen::Vector3f& last_nearest) {
  constexpr float kRounding = 1.0f + 1e-5f;
  return kRounding * (p - last_nearest).norm();
}

std::vector<Eigen::Vector3f> to_float(const std::vector<Vec3>& path_m) {
  std::vector<Eigen::Vector3f> path;
  path.reserve(path_m.size());
  for (const Vec3& p : path_m) path.push_back(p.cast<float>());
  return path;
}

Vec3 segment_into_sphere(const Vec3& p) {
  return -kSegmentLength_m * p.normalized();
}

void closest_point(benchmark::State& state, const Sphere& sphere, const std::vector<Vec3>& path_m) {
  const SurfaceIndex& index = sphere.index();
  std::optional<SurfacePoint> nearest;
  time_path(
      state, path_m.size(),
      [&] { nearest = index.closest_point(path_m.front(), kAcquisitionRadius_m); },
      [&](std::size_t n) {
        const Vec3& p = path_m[n];
        nearest = index.closest_point(p, tight_radius_m(p, nearest->point_m));
        benchmark::DoNotOptimize(nearest);
      },
      [&](std::size_t) { return nearest ? nullptr : "a closest point was lost"; });
}

void stock_closest_point(benchmark::State& state, const Sphere& sphere,
                         const std::vector<Vec3>& path_m) {
  const std::vector<Eigen::Vector3f> path = to_float(path_m);
  std::optional<StockPoint> nearest;
  time_path(
      state, path.size(),
      [&] {
        nearest =
            sphere.stock.closest_point(path.front(), static_cast<float>(kAcquisitionRadius_m));
      },
      [&](std::size_t n) {
        const Eigen::Vector3f& p = path[n];
        nearest = sphere.stock.closest_point(p, tight_radius_m(p, nearest->point_m));
        benchmark::DoNotOptimize(nearest);
      },
      [&](std::size_t) { return nearest ? nullptr : "a closest point was lost"; });
}

void first_hit(benchmark::State& state, const Sphere& sphere, const std::vector<Vec3>& path_m) {
  const SurfaceIndex& index = sphere.index();
  std::optional<SegmentHit> hit;
  time_path(
      state, path_m.size(), [] {},
      [&](std::size_t n) {
        hit = index.first_hit(path_m[n], segment_into_sphere(path_m[n]));
        benchmark::DoNotOptimize(hit);
      },
      [&](std::size_t) { return hit ? nullptr : "a segment through the surface missed it"; });
}

void stock_first_hit(benchmark::State& state, const Sphere& sphere,
                     const std::vector<Vec3>& path_m) {
  const std::vector<Eigen::Vector3f> path = to_float(path_m);
  std::optional<float> hit;
  time_path(
      state, path.size(), [] {},
      [&](std::size_t n) {
        const float length = static_cast<float>(kSegmentLength_m);
        hit = sphere.stock.first_hit(path[n], -length * path[n].normalized());
        benchmark::DoNotOptimize(hit);
      },
      [](std::size_t) -> SampleError { return nullptr; });
}

void packs_near(benchmark::State& state, const Sphere& sphere, const std::vector<Vec3>& path_m) {
  const SurfaceIndex& index = sphere.index();
  const double radius_m = kGatherPerPackDiagonal * index.mean_pack_diagonal_m();
  std::array<std::uint32_t, 256> packs{};
  std::size_t count = 0;
  std::size_t total = 0;
  time_path(
      state, path_m.size(), [] {},
      [&](std::size_t n) {
        count = index.packs_near(path_m[n], radius_m, packs);
        benchmark::DoNotOptimize(packs.data());
      },
      [&](std::size_t) -> SampleError {
        total += count;
        return nullptr;
      });
  state.counters["packs"] =
      benchmark::Counter(static_cast<double>(total), benchmark::Counter::kAvgIterations);
}

// Both sides must be answering the same question before their times are compared.
bool answers_agree(const Sphere& sphere, const std::vector<Vec3>& path_m) {
  for (std::size_t n = 0; n < path_m.size(); n += 17) {
    const Vec3& p = path_m[n];
    const auto ours = sphere.index().closest_point(p, kAcquisitionRadius_m);
    const auto stock =
        sphere.stock.closest_point(p.cast<float>(), static_cast<float>(kAcquisitionRadius_m));
    if (!ours || !stock) return false;
    if (std::abs(ours->distance_m - stock->distance_m) > kFloatAgreement_m) return false;
    const Vec3 d = segment_into_sphere(p);
    const auto our_hit = sphere.index().first_hit(p, d);
    const auto stock_hit = sphere.stock.first_hit(p.cast<float>(), d.cast<float>());
    if (!our_hit) return false;
    if (!stock_hit) continue;  // Embree misses some segments through edges; ours may not
    if (std::abs(our_hit->fraction - *stock_hit) * kSegmentLength_m > kFloatAgreement_m) {
      return false;
    }
  }
  return true;
}

using Workload = void (*)(benchmark::State&, const Sphere&, const std::vector<Vec3>&);

void run(benchmark::State& state, Workload workload, const HeightSwing& swing, int subdivisions,
         std::size_t sample_count) {
  const Sphere* target = sphere(subdivisions);
  if (!target) return state.SkipWithError("the sphere could not be compiled");
  if (!answers_agree(*target, path_over_sphere(kSphereRadius_m, kNear, sample_count))) {
    return state.SkipWithError("Palpate and Embree give different answers");
  }
  workload(state, *target, path_over_sphere(kSphereRadius_m, swing, sample_count));
  state.counters["triangles"] = static_cast<double>(sphere_triangles(subdivisions));
}

}  // namespace

void register_index_benchmarks(int subdivisions, std::size_t sample_count) {
  const auto add = [&](const std::string& name, Workload workload, const HeightSwing& swing) {
    benchmark::RegisterBenchmark(
        (name + "/" + std::to_string(sphere_triangles(subdivisions))).c_str(),
        [=](benchmark::State& state) { run(state, workload, swing, subdivisions, sample_count); })
        ->UseManualTime()
        ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * sample_count));
  };
  add("closest_point", closest_point, kNear);
  add("stock_closest_point", stock_closest_point, kNear);
  add("first_hit", first_hit, kNear);
  add("stock_first_hit", stock_first_hit, kNear);
  add("packs_near", packs_near, kOnSurface);
}

}  // namespace palpate::bench
