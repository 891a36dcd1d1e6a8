// libFuzzer's target: reads the bytes as a .glb or .gltf, whichever the content indicates, and
// compiles the scene if it is small. For all bytes the result must be a scene or an Error.
// PRESET=fuzz ./test.sh runs the target.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "engine/scene/scene.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"

// From libFuzzer: changes the bytes in place and returns the new size.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace palpate {
namespace {

// An empty folder for the asset, so that no external file exists.
const std::string& empty_folder() {
  static const test::TemporaryFolder folder;
  static const std::string path = folder.path();
  return path;
}

// So few triangles and nodes that compiling is as fast as reading.
bool is_small(const SceneDescription& scene) {
  constexpr std::size_t kMaxNodes = 64;
  constexpr std::size_t kMaxPoints = 4096;
  std::size_t points = 0;
  for (const MeshDescription& mesh : scene.meshes) {
    points += mesh.positions.size() + mesh.triangles.size();
  }
  return scene.nodes.size() <= kMaxNodes && points <= kMaxPoints;
}

void require(bool holds) {
  if (!holds) std::abort();
}

void require_below(const std::optional<std::uint32_t>& index, std::size_t count) {
  require(!index || *index < count);
}

void check_materials(const SceneDescription& scene, const MeshDescription& mesh) {
  require_below(mesh.haptic_material, scene.haptic_materials.size());
  std::size_t first = 0;
  for (const MaterialRun& run : mesh.material_runs) {
    require_below(run.material, scene.materials.size());
    require(run.first_triangle >= first && run.first_triangle < mesh.triangles.size());
    first = run.first_triangle;
  }
}

// A required map has its pixels, and every position of the mesh has coordinates in it.
void check_maps(const SceneDescription& scene, const MeshDescription& mesh) {
  const auto* haptic =
      mesh.haptic_material ? &scene.haptic_materials[*mesh.haptic_material] : nullptr;
  const auto check_map = [&](const TextureReference* map, const auto& coordinates) {
    require(coordinates.empty() || coordinates.size() == mesh.positions.size());
    if (map == nullptr) return;
    require(map->pixels && *map->pixels < scene.images.size() && !coordinates.empty());
  };
  for (const MaterialRun& run : mesh.material_runs) {
    const MaterialDescription none;
    check_map(texture_map(run.material ? scene.materials[*run.material] : none, haptic),
              mesh.texture_uv);
    check_map(friction_map(haptic), mesh.friction_uv);
  }
  for (const auto* all : {&mesh.texture_uv, &mesh.friction_uv}) {
    for (const auto& uv : *all) require(std::isfinite(uv[0]) && std::isfinite(uv[1]));
  }
}

void check_image(const ImageDescription& image) {
  require(image.width > 0 && image.height > 0);
  require(image.rgb.size() == std::size_t{3} * image.width * image.height);
}

// An invalid description is a bug for every file.
void check(const SceneDescription& scene) {
  require(!scene.meshes.empty() && !scene.nodes.empty());
  for (const MeshDescription& mesh : scene.meshes) {
    require(!mesh.triangles.empty());
    check_materials(scene, mesh);
    check_maps(scene, mesh);
    for (const Vec3& p : mesh.positions) require(p.allFinite());
    for (const Triangle& t : mesh.triangles) {
      for (const std::uint32_t vertex : t) require(vertex < mesh.positions.size());
    }
  }
  for (const NodeDescription& node : scene.nodes) {
    require(node.mesh < scene.meshes.size() && node.tree_node < scene.tree.size());
    require(node.linear_scene_mesh.allFinite() && node.translation_m.allFinite());
    require_below(node.physics_material, scene.physics_materials.size());
  }
  for (const ImageDescription& image : scene.images) check_image(image);
  for (const RegionDescription& region : scene.regions) {
    require(region.tree_node < scene.tree.size() && !region.parameters.empty());
    require(region.linear_scene_node.allFinite() && region.translation_m.allFinite());
  }
  for (const ContourDescription& contour : scene.contours) {
    require(contour.tree_node < scene.tree.size() && !contour.element.empty());
    require(contour.start_scene_m.allFinite() && contour.end_scene_m.allFinite());
    require(contour.problem.empty() == (contour.start_scene_m != contour.end_scene_m));
    require(contour.problem.empty() == contour.hint.empty());
  }
}

// --- Mutations that keep a GLB valid -------------------------------------------------------------

constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::size_t kFixedBytes = kHeaderBytes + 2 * kChunkHeaderBytes;

std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

struct Chunks {
  std::vector<std::uint8_t> json;
  std::vector<std::uint8_t> bin;
};

// The two chunks of a GLB that is long enough to have them; sizes as far as the bytes go.
Chunks split(std::span<const std::uint8_t> glb) {
  const std::size_t room = glb.size() - kFixedBytes;
  const std::size_t json_size = std::min<std::size_t>(word_at(glb, kHeaderBytes), room);
  const auto json = glb.subspan(kHeaderBytes + kChunkHeaderBytes, json_size);
  const auto bin = glb.subspan(kFixedBytes + json_size);
  return {{json.begin(), json.end()}, {bin.begin(), bin.end()}};
}

void change(std::vector<std::uint8_t>& part, std::size_t max_size) {
  const std::size_t size = part.size();
  part.resize(std::max(size, max_size));
  part.resize(LLVMFuzzerMutate(part.data(), size, part.size()));
}

std::string joined(const Chunks& chunks) {
  return test::glb_of({{"JSON", {chunks.json.begin(), chunks.json.end()}},
                       {std::string("BIN\0", 4), {chunks.bin.begin(), chunks.bin.end()}}});
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  ReadOptions posed;
  posed.pose = "#0@0.5";
  auto scene = read_gltf_bytes({data, size}, empty_folder(), "fuzz", posed);
  if (!scene) scene = read_gltf_bytes({data, size}, empty_folder(), "fuzz");
  if (!scene) {
    if (scene.error().problem.empty() || scene.error().path != "fuzz") std::abort();
    return 0;
  }
  check(*scene);
  if (is_small(*scene)) (void)Scene::compile(std::move(*scene)).ok();
  return 0;
}

// With inconsistent lengths the reader would reject every mutated GLB at once, so most mutations
// change one chunk and correct its length.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  using namespace palpate;
  std::minstd_rand random(seed);
  const bool is_glb = size >= kFixedBytes && std::memcmp(data, "glTF", 4) == 0;
  const auto choice = random() % 8;
  if (!is_glb || choice == 0) return LLVMFuzzerMutate(data, size, max_size);
  Chunks chunks = split({data, size});
  std::vector<std::uint8_t>& part = choice < 6 ? chunks.json : chunks.bin;
  change(part, max_size > size ? part.size() + (max_size - size) : part.size());
  const std::string changed = joined(chunks);
  if (changed.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, changed.data(), changed.size());
  return changed.size();
}
