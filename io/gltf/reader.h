#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/key_names.h"
#include "io/scene_description.h"

namespace palpate {

struct ReadOptions {
  // Parameters set outside the file, in order; the last override of a parameter applies.
  std::vector<MaterialOverride> overrides;
  // The pose in which the scene is read: "NAME@SECONDS" or "#number@SECONDS", with the name or the
  // number of an animation (see GltfPose::choose). Empty: the rest pose.
  std::string pose = {};
  MemoryLimit memory = {};  // limit for reading
  // The number or the name of a scene of the file (see GltfSceneChoice). Empty: the default scene.
  std::string scene = {};
  bool feels_hidden = false;  // reads nodes that KHR_node_visibility hides like visible ones
  // Reads SceneDescription::tree, scenes and hidden_nodes, and nothing else. A scene without a
  // triangle is then no error.
  bool reads_only_tree = false;
  // The keys of extras.palpate, for lines about keys in other places; null: keys are not searched.
  const KeyNames* key_names = nullptr;
};

// Reads the triangle geometry and the haptic declarations of materials (gltf/materials.h) of a glTF
// 2.0 asset. The asset is a .gltf with embedded or external buffers, or a .glb; the content
// determines the format. Reads one scene, with the full node hierarchy and without hidden nodes.
// Supports TRIANGLES, TRIANGLE_STRIP and TRIANGLE_FAN, every index type, sparse and normalised
// accessors, Draco and meshopt compression, and EXT_mesh_gpu_instancing. Only images that a haptic
// material or textureHeight requires are decoded (material_description.h). External files are read
// only from inside the folder of the asset.
//
// Skins, morph targets and animated nodes are read in one pose, which ReadOptions::pose selects.
// The rest pose has the node transforms and morph weights of the file (see gltf/animation.h,
// gltf/skin.h, gltf/morph.h). A note states the pose. A skinned mesh is described in the scene
// frame. Nodes that share a mesh, a skin and the morph weights share one MeshDescription; otherwise
// each pose has a separate one.
//
// Invalid input is an Error that names the file, the JSON path and the expected content; input is
// never repaired. Content that can be skipped without affecting the surfaces (cameras, points,
// lines) causes a warning. Contradictory content causes a warning, too: one version of it is used,
// and the warning states which (gltf/json_text.h, gltf/draco.h, gltf/schema.h). Input above the
// limits of gltf/limits.h is an Error. Not for the haptic thread. Thread-safe.
Result<SceneDescription> read_gltf(const std::string& path, const ReadOptions& options = {});

// Like read_gltf(), but for an asset in memory. folder: the folder of external buffers. name: the
// name of the asset in errors. SceneDescription::parse_ms is not set.
Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name,
                                         const ReadOptions& options = {});

}  // namespace palpate
