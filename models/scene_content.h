#pragma once

// What a glTF scene is made of, before it is written: several meshes, materials and nodes, and what
// they declare about how they feel. Frame: each mesh in that of its node, the nodes in that of the
// scene; metres. Plain values; thread-safe.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

// Each optional index counts within the vector of SceneContent that it is named after.
using Index = std::optional<std::size_t>;

struct MeshContent {
  std::string name;
  TriangleMesh mesh;
  std::vector<Point2> texture_coordinates = {};  // u to the right, v down; one a vertex, or none
  Index material = {};
  Index haptic_material = {};
};

struct MaterialContent {
  std::string name;
  nlohmann::json palpate = nullptr;                      // its extras.palpate; null for none
  std::optional<std::array<double, 4>> base_color = {};  // red, green, blue, opacity: linear, 0..1
  Index base_color_image = {};
  Index normal_image = {};
};

// Haptic maps by MPEG_haptic_material (ISO/IEC 23090-14).
struct HapticMaterialContent {
  std::string name;
  Index friction_image = {};
  Index vibrotactile_image = {};
};

struct NodeContent {
  std::string name;
  Index mesh = {};
  Vec3 translation_m = Vec3::Zero();
  Index physics_material = {};  // of a collider that has the node's own mesh
  nlohmann::json extras = nullptr;
};

struct SceneContent {
  std::vector<MeshContent> meshes = {};
  std::vector<MaterialContent> materials = {};
  std::vector<HapticMaterialContent> haptic_materials = {};
  std::vector<nlohmann::json> physics_materials = {};  // as KHR_physics_rigid_bodies has them
  std::vector<std::string> images = {};                // PNG files; each repeats as a texture
  std::vector<NodeContent> nodes = {};                 // all of them roots
  nlohmann::json extras = nullptr;
};

}  // namespace palpate
