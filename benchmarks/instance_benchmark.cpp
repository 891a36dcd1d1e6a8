// Ten thousand instances of one small sphere compared with one instance: loading, memory, and the
// cost of a query that must find the right instance first.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "benchmarks/loads.h"
#include "benchmarks/medians.h"
#include "benchmarks/percentiles.h"
#include "benchmarks/registration.h"
#include "benchmarks/trajectories.h"
#include "engine/scene/scene.h"
#include "haptics/proxy/god_object.h"
#include "models/glb_writer.h"
#include "models/primitives.h"

namespace palpate::bench {
namespace {

constexpr int kSubdivisions = 3;  // 1,280 triangles
constexpr double kRadius_m = 5e-3;
constexpr double kSpacing_m = 12e-3;
constexpr std::size_t kCrowd = 10'000;
constexpr int kAlongOneSide = 22;

// Points of a cubic lattice, sorted by distance from the origin; the first is the origin.
std::vector<Vec3> places(std::size_t count) {
  std::vector<Vec3> all;
  const int half = kAlongOneSide / 2;
  for (int x = -half; x < half; ++x) {
    for (int y = -half; y < half; ++y) {
      for (int z = -half; z < half; ++z) all.push_back(kSpacing_m * Vec3(x, y, z));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  all.resize(count);
  return all;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// The asset as .gltf with an external buffer, in a temporary folder that the destructor removes.
class CrowdFile {
 public:
  explicit CrowdFile(std::size_t count) {
    std::string folder = std::filesystem::temp_directory_path() / "palpate_benchmarks_XXXXXX";
    if (!::mkdtemp(folder.data())) return;
    folder_ = folder;
    const TriangleMesh sphere = icosphere(kSubdivisions, kRadius_m);
    std::vector<float> positions;
    for (const Vec3& p : sphere.positions_m) {
      for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(p[k]));
    }
    std::vector<std::uint32_t> indices;
    for (const Triangle& t : sphere.triangles) indices.insert(indices.end(), t.begin(), t.end());
    const std::string first = bytes_of(positions);
    const std::string second = bytes_of(indices);
    nlohmann::json asset = {
        {"asset", {{"version", "2.0"}}},
        {"buffers", {{{"uri", "crowd.bin"}, {"byteLength", first.size() + second.size()}}}},
        {"bufferViews",
         {{{"buffer", 0}, {"byteLength", first.size()}},
          {{"buffer", 0}, {"byteOffset", first.size()}, {"byteLength", second.size()}}}},
        {"accessors",
         {{{"bufferView", 0},
           {"componentType", 5126},
           {"count", positions.size() / 3},
           {"type", "VEC3"}},
          {{"bufferView", 1},
           {"componentType", 5125},
           {"count", indices.size()},
           {"type", "SCALAR"}}}},
        {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}}};
    for (const Vec3& p : places(count)) {
      asset["nodes"].push_back({{"mesh", 0}, {"translation", {p.x(), p.y(), p.z()}}});
    }
    is_written_ = write_file(folder_ / "crowd.bin", first + second).ok() &&
                  write_file(path(), asset.dump()).ok();
  }
  ~CrowdFile() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  CrowdFile(const CrowdFile&) = delete;
  CrowdFile& operator=(const CrowdFile&) = delete;

  std::string path() const { return folder_ / "crowd.gltf"; }
  bool is_written() const { return is_written_; }

 private:
  std::filesystem::path folder_;
  bool is_written_ = false;
};

std::string crowd_row(const std::string& name, std::size_t instances) {
  return name + "/" + std::to_string(instances) +
         "x";  // not a plain number, which would be read as a size
}

void load(benchmark::State& state, std::size_t instances) {
  const CrowdFile file(instances);
  if (!file.is_written()) return state.SkipWithError("the scene could not be written");
  std::vector<double> times_ms;
  for ([[maybe_unused]] auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    const auto scene = Scene::load(file.path());
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(elapsed.count());
    times_ms.push_back(1e3 * elapsed.count());
    if (!scene || scene->objects().size() != instances || scene->statistics().indices != 1) {
      return state.SkipWithError("the scene is not what was written");
    }
    state.counters["memory_bytes"] = static_cast<double>(scene->statistics().memory.total());
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + kLoads / 2, times_ms.end());
  state.counters["median_ms"] = times_ms[kLoads / 2];
}

Result<Scene> crowd_scene(std::size_t instances) {
  TriangleMesh sphere = icosphere(kSubdivisions, kRadius_m);
  SceneDescription description;
  description.meshes.push_back(
      {"sphere", std::move(sphere.positions_m), std::move(sphere.triangles)});
  for (const Vec3& p : places(instances)) {
    description.nodes.push_back({"sphere", 0, Mat3::Identity(), p});
  }
  return Scene::compile(std::move(description));
}

// Slides over the sphere in the middle. reuse: candidates are kept from tick to tick; otherwise
// every step of the proxy queries the whole scene.
void slide(benchmark::State& state, const std::string& name, std::size_t instances, bool reuse,
           std::size_t samples) {
  const auto scene = crowd_scene(instances);
  if (!scene) return state.SkipWithError("the scene could not be compiled");
  GodObjectSettings settings;
  settings.accuracy.reuse_candidates = reuse;
  std::vector<Vec3> goals;
  constexpr HeightSwing kPressing{-0.2 * kRadius_m, -0.02 * kRadius_m, 0.5};
  for (const Vec3& p : path_over_sphere(kRadius_m, kPressing, samples)) {
    goals.push_back(scene->world().to_solver(p));
  }
  std::optional<GodObject> god_object;
  ProxyState proxy;
  time_path(
      state, {samples, Caches::kWarm},
      [&] {
        god_object = std::move(*GodObject::create(scene->world(), settings));
        god_object->place(1.05 * goals.front());
        god_object->move_to(goals.front());
      },
      [](std::size_t) {}, [&](std::size_t n) { proxy = god_object->move_to(goals[n]); },
      [&](std::size_t) {
        return proxy.in_contact ? SampleError{} : "the proxy is not in contact";
      });
  state.counters["instances"] = static_cast<double>(instances);
  remember_p50(crowd_row(name, instances), state);
  if (instances > 1) report_ratio(state, "vs_one_p50", crowd_row(name, 1));
}

}  // namespace

void register_instance_benchmarks(const SampleCounts& counts) {
  for (const std::size_t instances : {std::size_t{1}, kCrowd}) {
    benchmark::RegisterBenchmark(crowd_row("load_instances", instances).c_str(),
                                 [=](benchmark::State& state) { load(state, instances); })
        ->UseManualTime()
        ->Iterations(kLoads)
        ->Unit(benchmark::kMillisecond);
  }
  for (const bool reuse : {true, false}) {
    const std::string name = reuse ? "instances_sliding" : "instances_sliding_searched";
    const std::size_t samples = counts.fewer();
    for (const std::size_t instances : {std::size_t{1}, kCrowd}) {
      benchmark::RegisterBenchmark(
          crowd_row(name, instances).c_str(),
          [=](benchmark::State& state) { slide(state, name, instances, reuse, samples); })
          ->UseManualTime()
          ->Iterations(static_cast<benchmark::IterationCount>(kRepeats * samples));
    }
  }
}

}  // namespace palpate::bench
