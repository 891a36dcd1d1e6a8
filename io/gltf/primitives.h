#pragma once

// The three triangle modes of glTF, and the triangles of a whole mesh.

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

// The triangles of a primitive (glTF 2.0, section 3.7.2.1). Every second triangle of a strip is
// reversed, so that all have the orientation of the first. The caller must have rejected lists with
// a remainder, and primitives with fewer than three indices. This function drops a remainder, and
// returns no triangle for fewer than three indices.
std::vector<Triangle> assemble_triangles(TriangleMode mode, std::span<const std::uint32_t> indices);

// The remaining budget, shared by all meshes of a scene.
struct GltfBudget {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t pose_work = 0;  // see kMaxGltfPoseWork
  // Counted so far, with kGltfTrianglesPerMesh for each mesh; see most_gltf_triangles() and
  // most_gltf_posed_triangles().
  std::size_t unposed_triangles = 0;
  std::size_t posed_triangles = 0;
};

// Counts triangles that are about to be stored. An error if the file has too little mesh data for
// so many. element, what: what needs them, for the error: `/nodes/7`, "poses mesh 3 once more".
// posed: whether they have a skin or morph weights.
std::optional<Error> count_triangles(const GltfAsset& asset, std::size_t triangles,
                                     const std::string& element, const std::string& what,
                                     bool posed, GltfBudget& budget);

// The way in which a node changes the shape of its mesh.
struct MeshPose {
  std::span<const double> morph_weights;  // empty: no morph target is applied
  const GltfSkin* skin = nullptr;         // applied after the morph targets
};

// All triangles of one mesh, possibly none. The positions are in the mesh frame or, if the pose has
// a skin, in the scene frame. Primitives that share their accessors share their vertices, unless
// their texture coordinates differ. Points, lines and primitives without POSITION are skipped with
// a warning. Reduces the budget by the amounts that it uses.
Result<MeshDescription> read_mesh(const GltfAsset& asset, std::size_t mesh, const MeshPose& pose,
                                  GltfMaterials& materials, GltfBudget& budget,
                                  std::vector<std::string>& warnings);

}  // namespace palpate
