#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

struct ReadOptions {
  // Parameters set outside the file, in order; the last override of a parameter applies.
  std::vector<MaterialOverride> overrides;
  // The pose in which the scene is read: "NAME@SECONDS" or "#number@SECONDS" of one animation (see
  // GltfPose::choose); empty: the rest pose.
  std::string pose = {};
  MemoryLimit memory = {};  // limit for reading
};

// Reads the triangle geometry of a glTF 2.0 asset (.gltf with embedded or external buffers, or
// .glb; the content determines the format): the default scene, else the first, else all root nodes;
// the full node hierarchy; TRIANGLES, TRIANGLE_STRIP and TRIANGLE_FAN; every index type; sparse and
// normalised accessors; Draco and meshopt compression; EXT_mesh_gpu_instancing; and the haptic
// declarations of materials (gltf/materials.h). Only images that a haptic material or textureHeight
// requires are decoded (material_description.h). External files are read only from inside the
// folder of the asset.
//
// Skins, morph targets and animated nodes are read in one pose: the rest pose, with the node
// transforms and morph weights of the file, or the pose of ReadOptions::pose (see gltf/animation.h,
// gltf/skin.h, gltf/morph.h). A note states the pose. A skinned mesh is described in the scene
// frame. Nodes that share a mesh, a skin and the morph weights share one MeshDescription; otherwise
// each pose has a separate one.
//
// Invalid input is an Error that names the file, the JSON path and the expected content; input is
// never repaired. Content that can be skipped without affecting the surfaces (cameras, points,
// lines) is a warning. So is contradictory content, of which one version is used; the warning
// states which (gltf/json_text.h, gltf/draco.h, gltf/schema.h). Input above gltf/limits.h is an
// Error. Not for the haptic thread. Thread-safe.
Result<SceneDescription> read_gltf(const std::string& path, const ReadOptions& options = {});

// The same for an asset in memory. folder: the folder of external buffers. name: the name of the
// asset in errors. SceneDescription::parse_ms is not set.
Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name,
                                         const ReadOptions& options = {});

}  // namespace palpate
