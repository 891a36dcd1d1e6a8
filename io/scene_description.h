#pragma once

// The content of a scene file, independent of the file format. Produced by read_gltf() and consumed
// by the engine.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "geometry/base/types.h"
#include "io/contour_description.h"
#include "io/material_description.h"
#include "io/pose_description.h"
#include "io/transform_product.h"

namespace palpate {

// The first triangle of a primitive in a mesh, and the material of the primitive.
struct MaterialRun {
  std::uint32_t first_triangle = 0;
  std::optional<std::uint32_t> material;  // index into SceneDescription::materials
};

// The triangles of one glTF mesh, its primitives appended in file order. A mesh that has two poses,
// by skins or morph weights, gives two descriptions.
struct MeshDescription {
  std::string name;
  std::vector<Vec3> positions;                  // mesh frame, metres, as in the file or as posed
  std::vector<Triangle> triangles;              // indices into positions
  std::vector<MaterialRun> material_runs = {};  // ascending; each extends to the next
  std::optional<std::uint32_t> haptic_material =
      {};  // index into SceneDescription::haptic_materials
  // Texture coordinates of the positions in the maps of texture_map() and friction_map(): fractions
  // of the width from the left and of the height from the top, with the map's transform applied;
  // any finite number. One for each position, zeros for primitives without a map; empty if no
  // primitive has a map.
  std::vector<std::array<double, 2>> texture_uv = {};
  std::vector<std::array<double, 2>> friction_uv = {};
};

// A node of the scene, with or without a mesh.
struct TreeNode {
  std::string name;              // "node 7" if the file has no name
  std::uint32_t file_index = 0;  // index into /nodes
  std::optional<std::uint32_t>
      parent;  // index into SceneDescription::tree, lower than the node's own
  bool has_mesh = false;
  Vec3 origin_m = Vec3::Zero();  // origin of the node frame, in the scene frame
};

// A placed mesh: one for each node that has a mesh with triangles, or for each instance of such a
// node.
struct NodeDescription {
  std::string name;        // the node's name; an instance's number is appended
  std::uint32_t mesh = 0;  // index into SceneDescription::meshes
  // p_scene = linear * p_mesh + translation_m, the product of the transforms of the node and its
  // ancestors, in double. The linear part may be any non-singular matrix, including scale, mirror
  // and shear.
  Mat3 linear_scene_mesh = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
  std::uint32_t tree_node = 0;  // index into SceneDescription::tree
  std::optional<std::uint32_t> physics_material =
      {};  // index into SceneDescription::physics_materials
  // The magnitudes in the product that gave linear_scene_mesh and translation_m. The default is for
  // numbers that were rounded once.
  TransformProduct product = {1, 0.0, Vec3::Zero(), 0.0};
};

// A node that declares a region of the scene instead of a surface: its extras.palpate has the key
// "medium".
struct RegionDescription {
  std::string name;                           // the node's name
  std::string element;                        // "/nodes/7/extras/palpate"
  std::vector<MaterialParameter> parameters;  // in the order of their keys
  std::uint32_t tree_node = 0;                // index into SceneDescription::tree
  // p_scene = linear * p_node + translation_m, as for a mesh, except that linear may be singular.
  Mat3 linear_scene_node = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
};

struct SceneDescription {
  std::string path;                     // path of the file, as the caller stated it
  std::vector<MeshDescription> meshes;  // meshes of the nodes, each once; none is empty
  std::vector<NodeDescription> nodes;   // in depth-first file order
  std::vector<TreeNode> tree;           // all nodes of the scene, depth first in file order
  // The materials that triangles refer to. If an override requires it, the material of the
  // triangles without a material is appended: name "default", element "default material".
  std::vector<MaterialDescription> materials;
  std::vector<PhysicsMaterialDescription> physics_materials;
  std::vector<HapticMaterialDescription> haptic_materials;
  // The extras.palpate of the scene: name "scene", element "/scenes/0/extras/palpate"; without
  // extras it has no parameters.
  MaterialDescription scene_parameters;
  std::vector<RegionDescription> regions;        // in depth-first file order
  std::vector<ContourDescription> contours;      // in depth-first file order
  std::vector<ImageDescription> images;          // targets of TextureReference::pixels
  std::vector<AnimationDescription> animations;  // all animations of the file, in file order
  std::optional<PoseDescription> pose;           // absent: the rest pose
  std::vector<std::string> notes;                // decisions of the reader, one line each: the pose
  std::vector<std::string> warnings;             // one line each
  double parse_ms = 0.0;
};

}  // namespace palpate
