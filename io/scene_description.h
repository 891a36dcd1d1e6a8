#pragma once

// What a scene file says, free of its file format. Made by read_gltf(), consumed by the engine.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "geometry/base/types.h"
#include "io/material_description.h"
#include "io/pose_description.h"
#include "io/transform_product.h"

namespace palpate {

// Where triangles of one primitive begin in a mesh, and what they are made of.
struct MaterialRun {
  std::uint32_t first_triangle = 0;
  std::optional<std::uint32_t> material;  // index into SceneDescription::materials
};

// The triangles of one glTF mesh, its primitives appended in file order. A mesh that is posed in
// two ways, by skins or morph weights, is two of these.
struct MeshDescription {
  std::string name;
  std::vector<Vec3> positions;                  // mesh frame, metres, as in the file or as posed
  std::vector<Triangle> triangles;              // indices into positions
  std::vector<MaterialRun> material_runs = {};  // in rising order; each lasts until the next begins
  std::optional<std::uint32_t> haptic_material =
      {};  // index into SceneDescription::haptic_materials
  // Where the positions lie in the maps of texture_map() and friction_map(), in fractions of their
  // width and height from the left and the top, with the transform of the map applied; any number.
  // One for each position; zeros at those of a primitive without a map; empty if none has one.
  std::vector<std::array<double, 2>> texture_uv = {};
  std::vector<std::array<double, 2>> friction_uv = {};
};

// A node of the scene that is read, with or without a mesh.
struct TreeNode {
  std::string name;                     // "node 7" when the file gives none
  std::uint32_t file_index = 0;         // in /nodes
  std::optional<std::uint32_t> parent;  // index into SceneDescription::tree, a lower one
  bool has_mesh = false;
  Vec3 origin_m = Vec3::Zero();  // of the node's frame, in the scene frame
};

// A mesh in its place: one for each node that carries a mesh with triangles, or for each instance
// that such a node asks for.
struct NodeDescription {
  std::string name;        // that of the node; instances have their number behind it
  std::uint32_t mesh = 0;  // index into SceneDescription::meshes
  // p_scene = linear * p_mesh + translation_m, the product of the node's ancestors in double.
  // Any non-singular linear part: scale, mirror and shear included.
  Mat3 linear_scene_mesh = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
  std::uint32_t tree_node = 0;  // index into SceneDescription::tree
  std::optional<std::uint32_t> physics_material =
      {};  // index into SceneDescription::physics_materials
  // That linear_scene_mesh and translation_m are. As it is here: numbers that were rounded once.
  TransformProduct product = {1, 0.0, Vec3::Zero(), 0.0};
};

// A node that declares a region of the scene instead of a surface: its extras.palpate has the key
// "medium".
struct RegionDescription {
  std::string name;                           // that of the node
  std::string element;                        // "/nodes/7/extras/palpate"
  std::vector<MaterialParameter> parameters;  // in the order of their keys
  std::uint32_t tree_node = 0;                // index into SceneDescription::tree
  // p_scene = linear * p_node + translation_m, as of a mesh; but it may be singular.
  Mat3 linear_scene_node = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
};

struct SceneDescription {
  std::string path;                     // the file, as the caller named it
  std::vector<MeshDescription> meshes;  // those of the nodes below, each once, none empty
  std::vector<NodeDescription> nodes;   // in depth-first file order
  std::vector<TreeNode> tree;           // all nodes of the scene, depth first in file order
  // Those that triangles refer to. Behind them, if an override calls for it, that of the triangles
  // without any: name "default", element "default material".
  std::vector<MaterialDescription> materials;
  std::vector<PhysicsMaterialDescription> physics_materials;
  std::vector<HapticMaterialDescription> haptic_materials;
  // The extras.palpate of the scene that is read: name "scene", element "/scenes/0/extras/palpate";
  // no parameters if it has none.
  MaterialDescription scene_parameters;
  std::vector<RegionDescription> regions;        // in depth-first file order
  std::vector<ImageDescription> images;          // those that TextureReference::pixels refer to
  std::vector<AnimationDescription> animations;  // all of the file, in its order
  std::optional<PoseDescription> pose;           // nothing: at rest
  std::vector<std::string> notes;     // what the reader decided, one line each: the pose it took
  std::vector<std::string> warnings;  // one line each
  double parse_ms = 0.0;
};

}  // namespace palpate
