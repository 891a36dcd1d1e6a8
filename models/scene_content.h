#pragma once

// The content of a glTF scene before encoding: meshes, materials and nodes with their haptic
// properties. A mesh is in the frame of its node, and the nodes are in the frame of the scene.
// Lengths are in metres. Plain values; thread-safe.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

// An optional index into the vector of SceneContent that the member's name indicates, for example
// into images for base_color_image.
using Index = std::optional<std::size_t>;

struct MeshContent {
  std::string name;
  TriangleMesh mesh;
  std::vector<Point2> texture_coordinates = {};  // u to the right, v down; one per vertex, or none
  Index material = {};
  Index haptic_material = {};
};

struct MaterialContent {
  std::string name;
  nlohmann::json palpate = nullptr;  // extras.palpate of the material; null: none
  std::optional<std::array<double, 4>> base_color = {};  // red, green, blue, opacity: linear, 0..1
  Index base_color_image = {};
  Index normal_image = {};
};

// Haptic maps in the extension MPEG_haptic_material (ISO/IEC 23090-14).
struct HapticMaterialContent {
  std::string name;
  Index friction_image = {};
  Index vibrotactile_image = {};
};

struct NodeContent {
  std::string name;
  Index mesh = {};
  Vec3 translation_m = Vec3::Zero();
  Index physics_material = {};  // physics material of a collider that has the node's own mesh
  nlohmann::json extras = nullptr;
};

struct SceneContent {
  std::vector<MeshContent> meshes = {};
  std::vector<MaterialContent> materials = {};
  std::vector<HapticMaterialContent> haptic_materials = {};
  std::vector<nlohmann::json> physics_materials = {};  // in the form of KHR_physics_rigid_bodies
  std::vector<std::string> images = {};                // PNG files; each is a repeating texture
  std::vector<NodeContent> nodes = {};                 // all nodes are roots
  nlohmann::json extras = nullptr;
};

}  // namespace palpate
