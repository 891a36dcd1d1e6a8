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

// The triangles of one glTF mesh, primitive by primitive in file order. If skins or morph weights
// give a mesh two poses, it has two descriptions.
struct MeshDescription {
  std::string name;
  std::vector<Vec3> positions;                  // mesh frame, metres, as in the file or as posed
  std::vector<Triangle> triangles;              // indices into positions
  std::vector<MaterialRun> material_runs = {};  // ascending; each extends to the next
  std::optional<std::uint32_t> haptic_material =
      {};  // index into SceneDescription::haptic_materials
  // For each element of positions, its texture coordinates in the map of texture_map() or
  // friction_map(): the fraction of the map's width from the left, and of its height from the top,
  // with the map's transform applied. They may be any finite numbers. In primitives without a map,
  // the pairs are zeros. A vector is empty if no primitive has a map.
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
  bool is_hidden = false;        // the node or an ancestor is hidden, and is not read
};

// Nodes with a mesh that are not read, because KHR_node_visibility hides them.
struct HiddenNodes {
  std::size_t count = 0;
  std::vector<std::string> first_names;  // of at most kMostHiddenNames nodes
};
inline constexpr std::size_t kMostHiddenNames = 5;

// The scenes that a file lists.
struct ListedScenes {
  std::size_t count = 0;
  std::vector<std::string> names;  // of at most the first kMostListedScenes; empty: without a name
  std::optional<std::size_t> loaded;  // absent: all root nodes
};
inline constexpr std::size_t kMostListedScenes = 100;

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
  // The magnitudes of the product that gave linear_scene_mesh and translation_m. The default
  // applies to numbers that were rounded once.
  TransformProduct product = {1, 0.0, Vec3::Zero(), 0.0};
};

// A node that declares a region of the scene instead of a surface: its extras.palpate has the key
// "medium".
struct RegionDescription {
  std::string name;                           // the node's name
  std::string element;                        // "/nodes/7/extras/palpate"
  std::vector<MaterialParameter> parameters;  // in the order of their keys
  std::uint32_t tree_node = 0;                // index into SceneDescription::tree
  // p_scene = linear * p_node + translation_m, as for a mesh, except that linear_scene_node may be
  // singular.
  Mat3 linear_scene_node = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
};

struct SceneDescription {
  std::string path;  // path of the file, as the caller stated it
  std::vector<std::string>
      files_read;  // the other files that were read, each once: buffers, images
  std::vector<MeshDescription> meshes;  // meshes of the nodes, each once; none is empty
  std::vector<NodeDescription> nodes;   // in depth-first file order
  std::vector<TreeNode> tree;           // all nodes of the scene, depth first in file order
  // The materials that triangles refer to. If an override requires it, a material for the triangles
  // without a material is appended, with the name "default" and the element "default material".
  std::vector<MaterialDescription> materials;
  std::vector<PhysicsMaterialDescription> physics_materials;
  std::vector<HapticMaterialDescription> haptic_materials;
  // The extras.palpate of the scene, as a material with the name "scene" and the element
  // "/scenes/0/extras/palpate". Without extras, it has no parameters.
  MaterialDescription scene_parameters;
  std::vector<RegionDescription> regions;        // in depth-first file order
  std::vector<ContourDescription> contours;      // in depth-first file order
  std::vector<ImageDescription> images;          // targets of TextureReference::pixels
  std::vector<AnimationDescription> animations;  // all animations of the file, in file order
  std::optional<PoseDescription> pose;           // absent: the rest pose
  ListedScenes scenes;
  HiddenNodes hidden_nodes;
  // Keys and groups for Palpate that are not applied, with the place where each belongs; one line
  // each.
  std::vector<std::string> unapplied_extras;
  std::vector<std::string> notes;     // decisions, such as the pose; one line each
  std::vector<std::string> warnings;  // one line each
  double parse_ms = 0.0;
};

}  // namespace palpate
