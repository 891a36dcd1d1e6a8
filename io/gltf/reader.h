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
  // What is set beside the file, in order: of two for one parameter the later one holds.
  std::vector<MaterialOverride> overrides;
  // The pose in which the scene is read: "NAME@SECONDS" or "#number@SECONDS" of one animation (see
  // GltfPose::choose); empty: at rest.
  std::string pose = {};
  MemoryLimit memory = {};  // that reading may take
};

// Reads the triangle geometry of a glTF 2.0 asset (.gltf with embedded or external buffers, or
// .glb; told apart by content): the default scene, else the first, else all root nodes; the full
// node hierarchy; TRIANGLES, TRIANGLE_STRIP and TRIANGLE_FAN; every index type; sparse and
// normalised accessors; Draco and meshopt compression; EXT_mesh_gpu_instancing; and what materials
// declare (gltf/materials.h). Of images only those are decoded that a haptic material or
// textureHeight calls for (material_description.h). External files are read only from inside the
// folder of the asset.
//
// Skins, morph targets and animated nodes are read in one pose: at rest, which is where the file
// has its nodes and with its morph weights, or in that of ReadOptions::pose (see gltf/animation.h,
// gltf/skin.h, gltf/morph.h). A note tells which. A skinned mesh is
// described in the scene frame. Nodes that share a mesh, a skin and the morph weights share one
// MeshDescription; otherwise each pose is one of its own.
//
// Bad input is refused by an Error that names the file, the JSON path and what was expected; it is
// never repaired. What is skipped without harm to the geometry (a camera, points and lines) is a
// warning, and so is what the file says twice, in two ways, of which one is read: the warning
// states which (gltf/json_text.h, gltf/draco.h, gltf/schema.h). What is beyond gltf/limits.h is
// refused. Not for the haptic thread. Thread-safe.
Result<SceneDescription> read_gltf(const std::string& path, const ReadOptions& options = {});

// The same for an asset in memory. folder: where external buffers may lie. name: what errors call
// the asset. SceneDescription::parse_ms is not set.
Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name,
                                         const ReadOptions& options = {});

}  // namespace palpate
