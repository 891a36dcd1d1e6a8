#pragma once

// The meshes of a scene: one for each pose in which nodes use a mesh of the file.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/animation.h"
#include "io/gltf/materials.h"
#include "io/gltf/nodes.h"
#include "io/gltf/primitives.h"
#include "io/gltf/skin.h"
#include "io/scene_description.h"

namespace palpate {

// Reads meshes into SceneDescription::meshes when nodes first use them. Nodes that share a mesh, a
// skin and the morph weights share one. Not thread-safe.
class PosedMeshes {
 public:
  // pose_work: what is left of kMaxGltfPoseWork. The other arguments must outlive this object.
  PosedMeshes(const GltfAsset& asset, const GltfPose& pose, std::size_t pose_work,
              GltfNodeWalk& walk, GltfMaterials& materials, SceneDescription& scene);

  // The index into SceneDescription::meshes of the mesh of a node of the file, in the node's pose;
  // nothing if the mesh has no triangle. Requires that the node has a mesh.
  Result<std::optional<std::uint32_t>> mesh_of(std::size_t node);

  std::size_t skinned_count() const { return skinned_meshes_; }
  std::size_t morphed_count() const { return morphed_meshes_; }

 private:
  using Weights = std::vector<double>;

  // A mesh in one pose, by its ids in the file.
  struct PosedMesh {
    std::size_t mesh = 0;
    std::optional<std::size_t> skin;
    const Weights* morph_weights = nullptr;  // in weights_; equal weights have equal pointers

    auto operator<=>(const PosedMesh&) const = default;
  };

  std::size_t first_equal(std::size_t mesh);
  std::optional<Error> check_further_pose(const PosedMesh& posed, std::size_t node) const;
  Result<std::optional<std::uint32_t>> read_in_pose(const PosedMesh& posed, std::size_t node);
  Result<const Weights*> weights_of(std::size_t node);
  const Weights* kept(Weights weights);
  Result<const GltfSkin*> skin_of(std::size_t skin_id);

  const GltfAsset& asset_;
  const GltfPose& pose_;
  GltfBudget budget_;
  GltfNodeWalk& walk_;
  GltfMaterials& materials_;
  SceneDescription& scene_;
  std::map<PosedMesh, std::optional<std::uint32_t>> meshes_;
  std::map<std::size_t, std::size_t> first_equal_;     // of meshes, by ids in the file
  std::map<std::size_t, std::size_t> triangles_;       // of meshes, by ids in the file
  std::size_t repeated_triangles_ = 0;                 // of meshes equal to others
  std::map<std::string, std::size_t> meshes_by_text_;  // those that differ
  std::set<Weights> weights_;
  std::map<std::size_t, const Weights*> default_weights_;  // by mesh id in the file
  std::set<std::pair<std::size_t, bool>> warned_;          // meshes read, and whether with a skin
  std::map<std::size_t, GltfSkin> skins_;                  // by id in the file
  std::size_t joint_count_ = 0;                            // of skins_
  std::size_t skinned_meshes_ = 0;
  std::size_t morphed_meshes_ = 0;
};

}  // namespace palpate
