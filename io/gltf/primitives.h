#pragma once

// The three ways in which glTF lists triangles, and what a whole mesh makes of its primitives.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/gltf/accessor.h"
#include "io/gltf/materials.h"
#include "io/gltf/skin.h"
#include "io/scene_description.h"

namespace palpate {

enum class TriangleMode { kList, kStrip, kFan };

// The triangles of a primitive, glTF 2.0, section 3.7.2.1: every second one of a strip is turned,
// so that all keep the orientation of the first. A list with a remainder loses it, fewer than three
// indices make no triangle: the caller must have refused both.
std::vector<Triangle> assemble_triangles(TriangleMode mode, std::span<const std::uint32_t> indices);

// How much more may be read; shared by all meshes of a scene.
struct GltfBudget {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t pose_work = 0;  // see kMaxGltfPoseWork
};

// How a node changes the shape of its mesh.
struct MeshPose {
  std::span<const double> morph_weights;  // empty: no target moves anything
  const GltfSkin* skin = nullptr;         // applied after the morph targets
};

// All triangles of one mesh, which may be none; its positions are in the scene frame if it has a
// skin. Primitives that share their accessors share the vertices, unless these lie elsewhere in
// their maps. Points, lines and primitives without POSITION are passed over with a warning. Takes
// from the budget what it uses.
Result<MeshDescription> read_mesh(const GltfAsset& asset, std::size_t mesh, const MeshPose& pose,
                                  GltfMaterials& materials, GltfBudget& budget,
                                  std::vector<std::string>& warnings);

}  // namespace palpate
