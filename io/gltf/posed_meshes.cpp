#include "io/gltf/posed_meshes.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"
#include "io/gltf/morph.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

// Differs for almost all meshes that differ; others are read separately.
std::string text_of(const tinygltf::Mesh& mesh) {
  std::string text = mesh.name;
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    text += "/" + std::to_string(primitive.material) + "," + std::to_string(primitive.indices);
    for (const auto& [name, accessor] : primitive.attributes) {
      text += "," + name + std::to_string(accessor);
    }
  }
  return text;
}

}  // namespace

PosedMeshes::PosedMeshes(const GltfAsset& asset, const GltfPose& pose, std::size_t pose_work,
                         GltfNodeWalk& walk, GltfMaterials& materials, SceneDescription& scene)
    : asset_(asset),
      pose_(pose),
      budget_{kMaxGltfVertices, kMaxGltfTriangles, pose_work, 0, 0},
      walk_(walk),
      materials_(materials),
      scene_(scene) {}

Result<std::optional<std::uint32_t>> PosedMeshes::mesh_of(std::size_t node) {
  const auto weights = weights_of(node);
  if (!weights) return weights.error();
  const tinygltf::Node& user = asset_.model.nodes[node];
  PosedMesh posed{first_equal(static_cast<std::size_t>(user.mesh)), std::nullopt, *weights};
  if (user.skin >= 0) posed.skin = static_cast<std::size_t>(user.skin);
  return read_in_pose(posed, node);
}

// This mesh, or one used before that is equal to it in all that the file says, if meshes that are
// equal have many triangles together: thousands of meshes may refer to the same accessors.
std::size_t PosedMeshes::first_equal(std::size_t mesh) {
  if (const auto known = first_equal_.find(mesh); known != first_equal_.end()) {
    return known->second;
  }
  const auto [other, is_new] = meshes_by_text_.emplace(text_of(asset_.model.meshes[mesh]), mesh);
  if (!is_new && asset_.model.meshes[other->second] == asset_.model.meshes[mesh] &&
      asset_.json["meshes"][other->second] == asset_.json["meshes"][mesh] &&
      (repeated_triangles_ += triangles_[other->second] + kGltfTrianglesPerMesh) >
          kMaxGltfRepeatedTriangles) {
    return first_equal_.emplace(mesh, other->second).first->second;
  }
  return first_equal_.emplace(mesh, mesh).first->second;
}

// An error if the mesh, which has been read in another pose, is posed once too often.
std::optional<Error> PosedMeshes::check_further_pose(const PosedMesh& posed,
                                                     std::size_t node) const {
  const auto known = triangles_.find(posed.mesh);
  if (known == triangles_.end() || known->second == 0) return std::nullopt;
  GltfBudget after = budget_;  // the triangles are counted when they are read
  return count_triangles(asset_, known->second + kGltfTrianglesPerMesh, gltf_element("nodes", node),
                         "poses mesh " + std::to_string(posed.mesh) + " once more",
                         posed.skin.has_value() || !posed.morph_weights->empty(), after);
}

// Reads the mesh if this is its first use in this pose, by a node.
Result<std::optional<std::uint32_t>> PosedMeshes::read_in_pose(const PosedMesh& posed,
                                                               std::size_t node) {
  if (const auto known = meshes_.find(posed); known != meshes_.end()) return known->second;
  if (auto error = check_further_pose(posed, node)) return *error;
  MeshPose pose{*posed.morph_weights, nullptr};
  if (posed.skin) {
    const auto skin = skin_of(*posed.skin);
    if (!skin) return skin.error();
    pose.skin = *skin;
  }
  // All skinned poses of a mesh give the same warnings, which are reported once.
  std::vector<std::string> already_reported;
  const bool is_new = warned_.emplace(posed.mesh, posed.skin.has_value()).second;
  auto mesh = read_mesh(asset_, posed.mesh, pose, materials_, budget_,
                        is_new ? scene_.warnings : already_reported);
  if (!mesh) return mesh.error();
  std::optional<std::uint32_t> index;
  triangles_[posed.mesh] = mesh->triangles.size();
  if (!mesh->triangles.empty()) {
    index = static_cast<std::uint32_t>(scene_.meshes.size());
    scene_.meshes.push_back(std::move(*mesh));
    skinned_meshes_ += posed.skin ? 1 : 0;
    morphed_meshes_ += posed.morph_weights->empty() ? 0 : 1;
  }
  meshes_.emplace(posed, index);
  return index;
}

// The morph weights of a node's mesh; empty if no target has an effect. The weights of a mesh are
// read only once, because many nodes may share many targets.
Result<const PosedMeshes::Weights*> PosedMeshes::weights_of(std::size_t node) {
  auto own = own_morph_weights(asset_, node, pose_);
  if (!own) return own.error();
  if (*own) {
    if ((*own)->size() > budget_.pose_work) {
      return gltf_error(ErrorCode::kLimitExceeded, gltf_element("nodes", node),
                        "raises the number of morph weights of all nodes above the limit");
    }
    budget_.pose_work -= (*own)->size();
    return kept(std::move(**own));
  }
  const auto mesh = static_cast<std::size_t>(asset_.model.nodes[node].mesh);
  if (const auto known = default_weights_.find(mesh); known != default_weights_.end()) {
    return known->second;
  }
  auto weights = default_morph_weights(asset_, mesh);
  if (!weights) return weights.error();
  return default_weights_.emplace(mesh, kept(std::move(*weights).value_or(Weights())))
      .first->second;
}

const PosedMeshes::Weights* PosedMeshes::kept(Weights weights) {
  if (std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0.0; })) {
    weights.clear();
  }
  return &*weights_.insert(std::move(weights)).first;
}

Result<const GltfSkin*> PosedMeshes::skin_of(std::size_t skin_id) {
  const auto known = skins_.find(skin_id);
  if (known != skins_.end()) return static_cast<const GltfSkin*>(&known->second);
  auto skin = read_skin(
      asset_, skin_id, kMaxGltfJoints - joint_count_,
      [&](std::size_t node) { return scene_transform(asset_, pose_, walk_, node); },
      scene_.warnings);
  if (!skin) return skin.error();
  joint_count_ += skin->T_scene_mesh.size();
  return static_cast<const GltfSkin*>(&skins_.emplace(skin_id, std::move(*skin)).first->second);
}

}  // namespace palpate
