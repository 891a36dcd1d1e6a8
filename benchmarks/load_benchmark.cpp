// From a file on the disk to the first answer, compared with the unavoidable steps on the same
// sphere: reading the file, OpenMesh's own add_face() and Embree's own build.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <malloc.h>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <benchmark/benchmark.h>
#include <nlohmann/json.hpp>

#include "benchmarks/loads.h"
#include "benchmarks/registration.h"
#include "benchmarks/sphere.h"
#include "benchmarks/stock_embree.h"
#include "models/glb_writer.h"

namespace palpate::bench {
namespace {

// Outside the sphere, near its surface.
const Vec3 kQuery_m(0.0, 0.0, 1.01 * kSphereRadius_m);
constexpr double kQueryRadius_m = 0.02 * kSphereRadius_m;

// The sphere as a .glb in a temporary folder that the destructor removes. Just written, so the file
// is in the page cache.
class SphereFile {
 public:
  explicit SphereFile(int subdivisions) {
    std::string folder = std::filesystem::temp_directory_path() / "palpate_benchmarks_XXXXXX";
    if (!::mkdtemp(folder.data())) return;
    folder_ = folder;
    const auto bytes =
        encode_glb({"sphere", "sphere", icosphere(subdivisions, kSphereRadius_m)}, nullptr);
    const auto written = bytes ? write_file(path(), *bytes) : bytes.error();
    if (written) size_ = *written;
  }
  ~SphereFile() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  SphereFile(const SphereFile&) = delete;
  SphereFile& operator=(const SphereFile&) = delete;

  std::string path() const { return folder_ / "sphere.glb"; }
  std::size_t size() const { return size_; }  // 0: could not be written

 private:
  std::filesystem::path folder_;
  std::size_t size_ = 0;
};

// Resident memory of this process, after malloc has returned its free memory to the system.
double resident_bytes() {
  ::malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0;
  double resident_pages = 0.0;
  statm >> pages >> resident_pages;
  return resident_pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

// The medians so far, by row, in milliseconds.
std::map<std::string, double>& medians_ms() {
  static std::map<std::string, double> medians;
  return medians;
}

using RunError = const char*;  // null: no error

// Times make(), but neither check() nor the destruction of the result.
template <typename Make, typename Check>
void time_making(benchmark::State& state, const std::string& row, Make make, Check check) {
  std::vector<double> times_ms;
  for ([[maybe_unused]] auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    const auto made = make();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    state.SetIterationTime(elapsed.count());
    times_ms.push_back(1e3 * elapsed.count());
    if (const RunError error = check(made)) {
      state.SkipWithError(error);
      return;
    }
  }
  const auto middle = times_ms.begin() + static_cast<std::ptrdiff_t>(times_ms.size() / 2);
  std::nth_element(times_ms.begin(), middle, times_ms.end());
  state.counters["median_ms"] = *middle;
  medians_ms()[row] = *middle;
}

void read_file(benchmark::State& state, int subdivisions, const std::string& row) {
  const SphereFile file(subdivisions);
  time_making(
      state, row,
      [&] {
        std::vector<char> bytes(file.size());
        std::ifstream(file.path(), std::ios::binary)
            .read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return bytes;
      },
      [](const std::vector<char>& bytes) {
        return std::string(bytes.data(), std::min<std::size_t>(bytes.size(), 4)) == "glTF"
                   ? nullptr
                   : "the sphere's file could not be written or read";
      });
}

using StockOpenMesh = OpenMesh::TriMesh_ArrayKernelT<>;

void openmesh_add_face(benchmark::State& state, int subdivisions, const std::string& row) {
  const TriangleMesh sphere = icosphere(subdivisions, kSphereRadius_m);
  time_making(
      state, row,
      [&] {
        const std::size_t faces = sphere.triangles.size();
        auto mesh = std::make_unique<StockOpenMesh>();
        mesh->reserve(sphere.positions_m.size(), faces / 2 * 3, faces);
        std::vector<OpenMesh::VertexHandle> vertices;
        vertices.reserve(sphere.positions_m.size());
        for (const Vec3& p : sphere.positions_m) {
          const Eigen::Vector3f q = p.cast<float>();
          vertices.push_back(mesh->add_vertex({q.x(), q.y(), q.z()}));
        }
        for (const Triangle& t : sphere.triangles) {
          mesh->add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
        }
        return mesh;
      },
      [&](const std::unique_ptr<StockOpenMesh>& mesh) {
        return mesh->n_faces() == sphere.triangles.size() ? nullptr : "OpenMesh refused a face";
      });
}

void embree_build(benchmark::State& state, int subdivisions, const std::string& row) {
  const TriangleMesh sphere = icosphere(subdivisions, kSphereRadius_m);
  time_making(
      state, row, [&] { return std::make_unique<StockSurface>(sphere); },
      [](const std::unique_ptr<StockSurface>& stock) {
        return stock->closest_point(kQuery_m.cast<float>(), static_cast<float>(kQueryRadius_m))
                   ? nullptr
                   : "the closest point was not found";
      });
}

struct LoadedSphere {
  Result<Scene> scene;
  std::optional<SurfacePoint> nearest;
};

LoadedSphere load_and_query(const std::string& path) {
  LoadedSphere loaded{Scene::load(path), {}};
  if (loaded.scene) {
    loaded.nearest = closest_point(*loaded.scene, kQuery_m, kQueryRadius_m);
  }
  return loaded;
}

// Reports the memory counted by the scene and the growth of the process.
void report_memory(benchmark::State& state, const std::string& path) {
  const double before = resident_bytes();
  const LoadedSphere loaded = load_and_query(path);
  if (!loaded.scene) return;
  const double after = resident_bytes();
  const SceneStatistics& statistics = loaded.scene->statistics();
  const auto triangles = static_cast<double>(statistics.cleaning.triangles);
  state.counters["bytes_per_triangle"] = static_cast<double>(statistics.memory.total()) / triangles;
  state.counters["resident_per_triangle"] = (after - before) / triangles;
}

void load_glb(benchmark::State& state, int subdivisions, const std::string& row) {
  const SphereFile file(subdivisions);
  time_making(
      state, row, [&] { return load_and_query(file.path()); },
      [&](const LoadedSphere& loaded) -> RunError {
        if (!loaded.scene) return "the sphere could not be loaded";
        if (!loaded.nearest) return "the closest point was not found";
        const bool is_whole =
            loaded.scene->statistics().cleaning.triangles == sphere_triangles(subdivisions);
        return is_whole ? nullptr : "a triangle was lost";
      });
  report_memory(state, file.path());
  // Reports no ratio if a filter excluded one of the parts.
  double parts_ms = 0.0;
  for (const char* part : {"read_file", "openmesh_add_face", "embree_build"}) {
    const auto median = medians_ms().find(row_name(part, subdivisions));
    if (median == medians_ms().end()) return;
    parts_ms += median->second;
  }
  if (medians_ms().contains(row)) state.counters["vs_parts"] = medians_ms()[row] / parts_ms;
}

struct LoadCase {
  const char* name;
  void (*workload)(benchmark::State&, int subdivisions, const std::string& row);
};

// The parts come before the whole, which reports its ratio to them.
constexpr LoadCase kLoadCases[] = {
    {"read_file", read_file},
    {"openmesh_add_face", openmesh_add_face},
    {"embree_build", embree_build},
    {"load_glb", load_glb},
};

}  // namespace

void register_load_benchmarks(int subdivisions) {
  for (const LoadCase& load_case : kLoadCases) {
    const std::string row = row_name(load_case.name, subdivisions);
    benchmark::RegisterBenchmark(row.c_str(),
                                 [=, &load_case](benchmark::State& state) {
                                   load_case.workload(state, subdivisions, row);
                                   state.counters["triangles"] =
                                       static_cast<double>(sphere_triangles(subdivisions));
                                 })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(kLoads);
  }
}

}  // namespace palpate::bench
