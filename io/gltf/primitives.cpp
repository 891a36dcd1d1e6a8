#include "io/gltf/primitives.h"

#include <algorithm>
#include <array>
#include <compare>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "io/gltf/attributes.h"
#include "io/gltf/draco.h"
#include "io/gltf/error.h"
#include "io/gltf/haptic_materials.h"
#include "io/gltf/limits.h"
#include "io/gltf/morph.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

std::optional<TriangleMode> triangle_mode(int mode) {
  switch (mode) {
    case TINYGLTF_MODE_TRIANGLES:
      return TriangleMode::kList;
    case TINYGLTF_MODE_TRIANGLE_STRIP:
      return TriangleMode::kStrip;
    case TINYGLTF_MODE_TRIANGLE_FAN:
      return TriangleMode::kFan;
    default:
      return std::nullopt;
  }
}

// The largest number of indices that gives at most this many triangles.
std::size_t max_index_count(TriangleMode mode, std::size_t triangles) {
  return mode == TriangleMode::kList ? 3 * triangles : triangles + 2;
}

std::optional<Error> check_index_count(TriangleMode mode, std::size_t count,
                                       const std::string& element) {
  const std::string found = "has " + std::to_string(count) + " vertices or indices; expected ";
  if (mode == TriangleMode::kList && count % 3 != 0) {
    return gltf_invalid(element, found + "a multiple of 3 for a list of triangles");
  }
  if (count < 3) return gltf_invalid(element, found + "3 or more");
  return std::nullopt;
}

// Reads the primitives of one mesh into one description.
class MeshReader {
 public:
  MeshReader(const GltfAsset& asset, std::size_t mesh, const MeshPose& pose,
             GltfMaterials& materials, GltfBudget& budget, std::vector<std::string>& warnings)
      : asset_(asset),
        mesh_id_(mesh),
        pose_(pose),
        materials_(materials),
        budget_(budget),
        warnings_(warnings) {}

  Result<MeshDescription> run() {
    const tinygltf::Mesh& mesh = asset_.model.meshes[mesh_id_];
    if (auto error = charge_pose(mesh)) return *error;
    description_.name = mesh.name.empty() ? "mesh " + std::to_string(mesh_id_) : mesh.name;
    const auto haptic_material = haptic_material_of_mesh(asset_.json, mesh_id_);
    if (!haptic_material) return haptic_material.error();
    description_.haptic_material = *haptic_material;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const std::string element =
          gltf_element("meshes", mesh_id_, "primitives/" + std::to_string(i));
      if (auto error = read_primitive(i, element)) return *error;
    }
    for (auto* all : {&description_.texture_uv, &description_.friction_uv}) {
      if (!all->empty()) all->resize(description_.positions.size());
    }
    return std::move(description_);
  }

 private:
  bool is_posed() const { return pose_.skin != nullptr || !pose_.morph_weights.empty(); }

  // The JSON of the mesh is read again for every pose, and a small file can require many poses.
  std::optional<Error> charge_pose(const tinygltf::Mesh& mesh) {
    if (!is_posed()) return std::nullopt;
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      constexpr std::size_t kPerPrimitive = 16;  // relative to a vertex: names, look-ups, warnings
      constexpr std::size_t kPerTarget = 64;     // to find and check its data
      const std::size_t cost =
          kPerPrimitive + primitive.attributes.size() + kPerTarget * primitive.targets.size();
      if (cost > budget_.pose_work) {
        return gltf_error(ErrorCode::kLimitExceeded, gltf_element("meshes", mesh_id_),
                          "has too many poses: more than " + std::to_string(kMaxGltfPoseWork) +
                              " primitives and targets");
      }
      budget_.pose_work -= cost;
    }
    return std::nullopt;
  }

  std::optional<Error> read_primitive(std::size_t primitive_id, const std::string& element) {
    const tinygltf::Primitive& primitive = asset_.model.meshes[mesh_id_].primitives[primitive_id];
    const auto mode = triangle_mode(primitive.mode);
    if (!mode) {
      warnings_.push_back(element + ": points and lines are left out");
      return std::nullopt;
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
      warnings_.push_back(element + ": has no POSITION and is left out");
      return std::nullopt;
    }
    const auto compressed =
        read_draco_primitive(asset_, mesh_id_, primitive_id, budget_.vertices, budget_.triangles);
    if (!compressed) return compressed.error();
    if (*compressed) {
      const auto& warnings = (*compressed)->warnings();
      warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
    }
    if (auto error = begin_run(primitive.material)) return error;
    const auto accessor = static_cast<std::size_t>(position->second);
    if (*compressed) return append_compressed(primitive, **compressed, accessor, element);
    const auto vertices = vertices_of(primitive, accessor, element);
    if (!vertices) return vertices.error();
    auto triangles = triangles_of(primitive, *mode, vertices->count, element);
    if (!triangles) return triangles.error();
    return append(std::move(*triangles), vertices->first, element);
  }

  // Appends a compressed primitive, whose triangles are a list in every mode.
  std::optional<Error> append_compressed(const tinygltf::Primitive& primitive,
                                         const DracoPrimitive& compressed, std::size_t accessor,
                                         const std::string& element) {
    const auto vertices = vertices_of(primitive, compressed, accessor, element);
    if (!vertices) return vertices.error();
    return append(assemble_triangles(TriangleMode::kList, compressed.indices()), vertices->first,
                  element);
  }

  struct VertexRange {
    std::uint32_t first = 0;  // index into the positions of the description
    std::size_t count = 0;
  };

  using Coordinates = std::vector<std::array<double, 2>>;

  // The source of the coordinates in a map.
  struct MapSource {
    int accessor = -1;
    std::array<double, 2> offset;
    double rotation_rad = 0.0;
    std::array<double, 2> scale;

    auto operator<=>(const MapSource&) const = default;
  };

  // The source of vertices. Equal sources give equal vertices.
  struct VertexSource {
    std::vector<int> positions;  // accessors, including those of the pose
    std::optional<MapSource> texture;
    std::optional<MapSource> friction;

    auto operator<=>(const VertexSource&) const = default;
  };

  // Decodes and poses the vertices unless that is already done.
  Result<VertexRange> vertices_of(const tinygltf::Primitive& primitive, std::size_t accessor,
                                  const std::string& element) {
    const VertexSource source{sources_of(primitive), map_source(primitive, maps_.texture),
                              map_source(primitive, maps_.friction)};
    if (const auto known = ranges_.find(source); known != ranges_.end()) return known->second;
    auto positions = read_positions(asset_, accessor, budget_.vertices);
    if (!positions) return positions.error();
    if (auto error = pose_positions(primitive, nullptr, element, *positions)) return *error;
    const auto range = append_vertices(primitive, nullptr, element, std::move(*positions));
    if (range) ranges_.emplace(source, *range);
    return range;
  }

  // Compressed vertices are in the order of their stream, so primitives do not share them.
  Result<VertexRange> vertices_of(const tinygltf::Primitive& primitive,
                                  const DracoPrimitive& compressed, std::size_t accessor,
                                  const std::string& element) {
    auto positions = compressed.has("POSITION")
                         ? compressed.positions()
                         : read_positions(asset_, accessor, budget_.vertices);
    if (!positions) return positions.error();
    if (positions->size() != compressed.vertex_count()) {
      return gltf_invalid(element + "/attributes/POSITION",
                          "has " + std::to_string(positions->size()) +
                              " elements, but the compressed attributes have " +
                              std::to_string(compressed.vertex_count()));
    }
    if (auto error = pose_positions(primitive, &compressed, element, *positions)) return *error;
    return append_vertices(primitive, &compressed, element, std::move(*positions));
  }

  // Appends the vertices with their coordinates in the required maps.
  Result<VertexRange> append_vertices(const tinygltf::Primitive& primitive,
                                      const DracoPrimitive* compressed, const std::string& element,
                                      std::vector<Vec3> positions) {
    for (const auto& [map, all] : {std::pair(maps_.texture, &description_.texture_uv),
                                   std::pair(maps_.friction, &description_.friction_uv)}) {
      if (map == nullptr) continue;
      const auto coordinates =
          read_texture_coordinates(asset_, primitive, compressed, element, *map, positions.size());
      if (!coordinates) return coordinates.error();
      all->resize(description_.positions.size());
      all->insert(all->end(), coordinates->begin(), coordinates->end());
    }
    budget_.vertices -= positions.size();
    auto& all = description_.positions;
    const VertexRange range{static_cast<std::uint32_t>(all.size()), positions.size()};
    if (all.empty()) {
      all = std::move(positions);
    } else {
      all.insert(all.end(), positions.begin(), positions.end());
    }
    return range;
  }

  static std::optional<MapSource> map_source(const tinygltf::Primitive& primitive,
                                             const TextureReference* map) {
    if (map == nullptr) return std::nullopt;
    const auto attribute = primitive.attributes.find("TEXCOORD_" + std::to_string(map->tex_coord));
    const bool missing =
        attribute == primitive.attributes.end();  // reported when the attribute is read
    return MapSource{missing ? -1 : attribute->second, map->uv_offset, map->uv_rotation_rad,
                     map->uv_scale};
  }

  // The accessors from which the posed positions are computed.
  std::vector<int> sources_of(const tinygltf::Primitive& primitive) const {
    std::vector<int> sources = {primitive.attributes.at("POSITION")};
    if (pose_.skin) {
      for (const auto& [name, accessor] : primitive.attributes) {
        if (name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")) {
          sources.push_back(accessor);
        }
      }
    }
    if (!pose_.morph_weights.empty()) {
      for (const auto& target : primitive.targets) {
        const auto position = target.find("POSITION");
        sources.push_back(position == target.end() ? -1 : position->second);
      }
    }
    return sources;
  }

  std::optional<Error> pose_positions(const tinygltf::Primitive& primitive,
                                      const DracoPrimitive* compressed, const std::string& element,
                                      std::vector<Vec3>& positions) {
    if (!pose_.morph_weights.empty()) {
      auto error = add_morph_targets(asset_, primitive, element, pose_.morph_weights,
                                     budget_.pose_work, positions);
      if (error) return error;
    }
    if (pose_.skin) {
      auto error = apply_skin(asset_, primitive, compressed, element, *pose_.skin,
                              budget_.pose_work, positions, warnings_);
      if (error) return error;
    }
    const auto wrong = std::find_if(positions.begin(), positions.end(),
                                    [](const Vec3& position) { return !position.allFinite(); });
    if (wrong == positions.end()) return std::nullopt;
    return gltf_invalid(
        element, "the pose of vertex " + std::to_string(wrong - positions.begin()) + " overflows");
  }

  Result<std::vector<Triangle>> triangles_of(const tinygltf::Primitive& primitive,
                                             TriangleMode mode, std::size_t vertex_count,
                                             const std::string& element) {
    const auto count = index_count_of(primitive, mode, vertex_count, element);
    if (!count) return count.error();
    if (auto error = check_index_count(mode, *count, element)) return *error;
    std::vector<Triangle> triangles;
    if (mode == TriangleMode::kList) {
      // The indices are already those of triangles.
      static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
      triangles.resize(*count / 3);
      const std::span<std::uint32_t> indices(triangles.front().data(), *count);
      if (auto error = read_checked(primitive, mode, vertex_count, element, indices)) return *error;
      return triangles;
    }
    std::vector<std::uint32_t> indices(*count);
    if (auto error = read_checked(primitive, mode, vertex_count, element, indices)) return *error;
    return assemble_triangles(mode, indices);
  }

  Result<std::size_t> index_count_of(const tinygltf::Primitive& primitive, TriangleMode mode,
                                     std::size_t vertex_count, const std::string& element) const {
    const std::size_t max_count = max_index_count(mode, budget_.triangles);
    if (primitive.indices >= 0) {
      return index_count(asset_, static_cast<std::size_t>(primitive.indices), max_count);
    }
    if (vertex_count <= max_count) return vertex_count;
    return gltf_error(
        ErrorCode::kLimitExceeded, element,
        "has more triangles than can still be read, " + std::to_string(budget_.triangles));
  }

  std::optional<Error> read_checked(const tinygltf::Primitive& primitive, TriangleMode mode,
                                    std::size_t vertex_count, const std::string& element,
                                    std::span<std::uint32_t> indices) {
    if (primitive.indices < 0) {
      std::iota(indices.begin(), indices.end(), 0u);
      return std::nullopt;
    }
    const auto accessor = static_cast<std::size_t>(primitive.indices);
    if (auto error = read_indices(asset_, accessor, indices)) return error;
    const auto wrong = std::find_if(indices.begin(), indices.end(),
                                    [&](std::uint32_t index) { return index >= vertex_count; });
    if (wrong != indices.end()) {
      return gltf_invalid(element + "/indices", "index " + std::to_string(wrong - indices.begin()) +
                                                    " is " + std::to_string(*wrong) +
                                                    ", but the primitive has " +
                                                    std::to_string(vertex_count) + " vertices");
    }
    return check_restart(primitive, mode, indices, element);
  }

  // The index reserved for primitive restart (section 3.7.2.1) is not allowed. Real exporters use
  // it for the last of 256 vertices. A list has nothing to restart, so in a list it can only be a
  // vertex; elsewhere it is an error.
  std::optional<Error> check_restart(const tinygltf::Primitive& primitive, TriangleMode mode,
                                     std::span<const std::uint32_t> indices,
                                     const std::string& element) {
    const auto reserved = restart_index(asset_, static_cast<std::size_t>(primitive.indices));
    const auto found = std::find(indices.begin(), indices.end(), reserved);
    if (found == indices.end()) return std::nullopt;
    const std::string problem = "index " + std::to_string(found - indices.begin()) + " is " +
                                std::to_string(reserved) +
                                ", the largest of its type, which glTF does not allow";
    if (mode != TriangleMode::kList) return gltf_invalid(element + "/indices", problem);
    warnings_.push_back(element + "/indices: " + problem +
                        "; it is read as an ordinary vertex index");
    return std::nullopt;
  }

  // Begins a run of triangles with this material (id in the file; -1: none) and finds the maps that
  // the run requires.
  std::optional<Error> begin_run(int file_material) {
    std::optional<std::uint32_t> material;
    if (file_material >= 0) {
      const auto index = materials_.index_of(static_cast<std::uint32_t>(file_material));
      if (!index) return index.error();
      material = *index;
    }
    maps_ = materials_.call_maps(material, description_.haptic_material);
    auto& runs = description_.material_runs;
    if (runs.empty() || runs.back().material != material) {
      runs.push_back({static_cast<std::uint32_t>(description_.triangles.size()), material});
    }
    return std::nullopt;
  }

  std::optional<Error> append(std::vector<Triangle> triangles, std::uint32_t first_vertex,
                              const std::string& element) {
    budget_.triangles -= triangles.size();
    const std::size_t of_mesh = description_.triangles.empty() ? kGltfTrianglesPerMesh : 0;
    auto error =
        count_triangles(asset_, of_mesh + triangles.size(), element,
                        "has too many triangles for the data of the file", is_posed(), budget_);
    if (error) return error;
    if (first_vertex > 0) {
      for (Triangle& t : triangles) {
        for (std::uint32_t& vertex : t) vertex += first_vertex;
      }
    }
    auto& all = description_.triangles;
    if (all.empty()) {
      all = std::move(triangles);
    } else {
      all.insert(all.end(), triangles.begin(), triangles.end());
    }
    return std::nullopt;
  }

  const GltfAsset& asset_;
  std::size_t mesh_id_;
  const MeshPose& pose_;
  GltfMaterials& materials_;
  GltfBudget& budget_;
  std::vector<std::string>& warnings_;
  MeshDescription description_;
  GltfMaterials::Maps maps_;  // of the current primitive
  std::map<VertexSource, VertexRange> ranges_;
};

}  // namespace

std::vector<Triangle> assemble_triangles(TriangleMode mode,
                                         std::span<const std::uint32_t> indices) {
  std::vector<Triangle> triangles;
  if (indices.size() < 3) return triangles;
  const std::size_t count = mode == TriangleMode::kList ? indices.size() / 3 : indices.size() - 2;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    switch (mode) {
      case TriangleMode::kList:
        triangles.push_back({indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]});
        break;
      case TriangleMode::kStrip:
        triangles.push_back({indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
        break;
      case TriangleMode::kFan:
        triangles.push_back({indices[i + 1], indices[i + 2], indices[0]});
        break;
    }
  }
  return triangles;
}

std::optional<Error> count_triangles(const GltfAsset& asset, std::size_t triangles,
                                     const std::string& element, const std::string& what,
                                     bool posed, GltfBudget& budget) {
  const std::uint64_t bytes = asset.buffers.mesh_bytes();
  const std::size_t most = posed ? most_gltf_posed_triangles(bytes) : most_gltf_triangles(bytes);
  std::size_t& counted = posed ? budget.posed_triangles : budget.unposed_triangles;
  if (triangles <= most - std::min(most, counted)) {
    counted += triangles;
    return std::nullopt;
  }
  return gltf_error(
      ErrorCode::kLimitExceeded, element,
      what + ": with it, the meshes " +
          (posed ? "with skins or morph weights, each counted once for each pose,"
                 : "without skins and morph weights") +
          " count as " + std::to_string(counted + triangles) + " triangles; expected at most " +
          std::to_string(most) + " for the " + std::to_string(bytes) +
          " bytes of mesh data that were read",
      "let nodes share one mesh in one pose, or divide the scene among several files");
}

Result<MeshDescription> read_mesh(const GltfAsset& asset, std::size_t mesh, const MeshPose& pose,
                                  GltfMaterials& materials, GltfBudget& budget,
                                  std::vector<std::string>& warnings) {
  return MeshReader(asset, mesh, pose, materials, budget, warnings).run();
}

}  // namespace palpate
