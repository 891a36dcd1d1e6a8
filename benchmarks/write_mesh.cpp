// Writes a mesh of the benchmarks as a GLB file, for commands that load files.
//
// usage: write_mesh FILE sphere SUBDIVISIONS | write_mesh FILE scan CELL_M
// A sphere of 8 subdivisions has 1.3 million triangles, a scan of 0.00091 m 1.25 million.

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "benchmarks/scan_mesh.h"
#include "models/glb_writer.h"
#include "models/primitives.h"

namespace {

constexpr double kSphereRadius_m = 0.1;
constexpr int kMostSubdivisions = 10;

// Without triangles if the arguments are no mesh.
palpate::TriangleMesh mesh_of(std::string_view kind, const char* size) {
  const double number = std::atof(size);
  if (kind == "scan" && number > 0.0) {
    return palpate::bench::scan_of(palpate::bench::ScannedBody(), number);
  }
  if (kind == "sphere" && number >= 1.0 && number <= kMostSubdivisions) {
    return palpate::icosphere(static_cast<int>(number), kSphereRadius_m);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  palpate::GlbContent content;
  if (argc == 4) content.mesh = mesh_of(argv[2], argv[3]);
  const std::size_t triangles = content.mesh.triangles.size();
  if (triangles == 0) {
    std::fprintf(stderr,
                 "usage: write_mesh FILE sphere SUBDIVISIONS | write_mesh FILE scan CELL_M\n");
    return 2;
  }
  content.name = argv[2];
  content.material = "plastic";
  const auto glb = palpate::encode_glb(std::move(content), nullptr);
  if (!glb) {
    std::fprintf(stderr, "write_mesh: %s\n", glb.error().to_string().c_str());
    return 2;
  }
  const auto written = palpate::write_file(argv[1], *glb);
  if (!written) {
    std::fprintf(stderr, "write_mesh: %s\n", written.error().to_string().c_str());
    return 2;
  }
  std::printf("%zu triangles\n", triangles);
  return 0;
}
