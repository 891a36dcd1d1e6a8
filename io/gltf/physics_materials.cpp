#include "io/gltf/physics_materials.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/material_lists.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
constexpr const char* kPhysicsMaterials = "/extensions/KHR_physics_rigid_bodies/physicsMaterials";

MaybeError read_coefficient(const Json& object, const std::string& element, const char* name,
                            std::optional<double>& value) {
  if (!object.contains(name)) return std::nullopt;
  double number = 0.0;
  if (auto error = read_number(object, element, name, number)) return error;
  value = number;
  if (number >= 0.0) return std::nullopt;
  return gltf_expected(element + "/" + name, object[name], "a number that is not negative");
}

MaybeError read_combine_mode(const Json& object, const std::string& element, const char* name,
                             CombineMode& mode) {
  constexpr std::pair<const char*, CombineMode> kModes[] = {{"average", CombineMode::kAverage},
                                                            {"minimum", CombineMode::kMinimum},
                                                            {"maximum", CombineMode::kMaximum},
                                                            {"multiply", CombineMode::kMultiply}};
  const auto found = object.find(name);
  if (found == object.end()) return std::nullopt;
  for (const auto& [text, value] : kModes) {
    if (*found != text) continue;
    mode = value;
    return std::nullopt;
  }
  return gltf_expected(element + "/" + name, *found,
                       "\"average\", \"minimum\", \"maximum\" or \"multiply\"");
}

MaybeError read_physics_list(const Json& root, SceneDescription& scene) {
  const auto list = extension_list(root, kPhysics, "physicsMaterials");
  if (!list) return list.error();
  if (!*list) return std::nullopt;
  constexpr const char* kKnown[] = {"staticFriction", "dynamicFriction", "restitution",
                                    "frictionCombine", "restitutionCombine"};
  for (const Json& object : **list) {
    const std::string element =
        kPhysicsMaterials + ("/" + std::to_string(scene.physics_materials.size()));
    if (!object.is_object()) return gltf_expected(element, object, "an object");
    PhysicsMaterialDescription m;
    for (const auto& [name, value] : {std::pair("staticFriction", &m.static_friction),
                                      std::pair("dynamicFriction", &m.dynamic_friction),
                                      std::pair("restitution", &m.restitution)}) {
      if (auto error = read_coefficient(object, element, name, *value)) return error;
    }
    for (const auto& [name, mode] : {std::pair("frictionCombine", &m.friction_combine),
                                     std::pair("restitutionCombine", &m.restitution_combine)}) {
      if (auto error = read_combine_mode(object, element, name, *mode)) return error;
    }
    warn_about_others(object, element, kKnown, scene.warnings);
    scene.physics_materials.push_back(m);
  }
  return std::nullopt;
}

struct Collider {
  std::optional<std::uint32_t> material;     // index into physicsMaterials
  std::optional<std::size_t> geometry_node;  // index into /nodes
};

// The collider of a node; empty if the node has none.
Result<Collider> read_collider(const Json& root, std::size_t node, std::size_t material_count) {
  const std::string node_element = gltf_element("nodes", node);
  const auto extension = find_extension(root["nodes"][node], node_element, kPhysics);
  if (!extension) return extension.error();
  Collider collider;
  if (!*extension) return collider;
  const auto object = (*extension)->find("collider");
  if (object == (*extension)->end()) return collider;
  const std::string element = node_element + "/extensions/" + kPhysics + "/collider";
  if (!object->is_object()) return gltf_expected(element, *object, "an object");
  const auto material =
      optional_id(*object, element, "physicsMaterial", kPhysicsMaterials, material_count);
  if (!material) return material.error();
  if (*material) collider.material = static_cast<std::uint32_t>(**material);
  const auto geometry = object->find("geometry");
  if (geometry == object->end()) return collider;
  const std::string geometry_element = element + "/geometry";
  if (!geometry->is_object()) return gltf_expected(geometry_element, *geometry, "an object");
  const auto geometry_node =
      optional_id(*geometry, geometry_element, "node", "/nodes", root["nodes"].size());
  if (!geometry_node) return geometry_node.error();
  collider.geometry_node = *geometry_node;
  return collider;
}

MaybeError bind_physics_materials(const Json& root, SceneDescription& scene) {
  using Materials = std::vector<std::optional<std::uint32_t>>;
  Materials own(scene.tree.size());
  std::map<std::size_t, std::uint32_t> named;  // by node of the file
  std::size_t disagreements = 0;
  std::string first_disagreement;
  for (std::size_t i = 0; i < scene.tree.size(); ++i) {
    const std::size_t node = scene.tree[i].file_index;
    const auto collider = read_collider(root, node, scene.physics_materials.size());
    if (!collider) return collider.error();
    own[i] = collider->material;
    if (!collider->material || !collider->geometry_node) continue;
    const auto [known, is_new] = named.emplace(*collider->geometry_node, *collider->material);
    if (is_new || known->second == *collider->material) continue;
    if (++disagreements > 1) continue;
    first_disagreement = gltf_element("nodes", node) + ": its collider assigns " +
                         gltf_element("nodes", known->first) + " the physics material " +
                         std::to_string(*collider->material) +
                         "; the material of an earlier collider is kept, " +
                         std::to_string(known->second);
  }
  if (disagreements > 1) {
    first_disagreement +=
        "; " + std::to_string(disagreements - 1) + " further colliders disagree in the same way";
  }
  if (disagreements > 0) scene.notes.push_back(first_disagreement);
  // Parents precede their children in the tree.
  Materials from_geometry(scene.tree.size());
  for (std::size_t i = 0; i < scene.tree.size(); ++i) {
    const TreeNode& node = scene.tree[i];
    const auto found = named.find(node.file_index);
    if (found != named.end()) {
      from_geometry[i] = found->second;
    } else if (node.parent) {
      from_geometry[i] = from_geometry[*node.parent];
    }
  }
  for (NodeDescription& node : scene.nodes) {
    const std::size_t i = node.tree_node;
    node.physics_material = own[i] ? own[i] : from_geometry[i];
  }
  return std::nullopt;
}

}  // namespace

MaybeError read_physics_materials(const Json& root, SceneDescription& scene) {
  if (auto error = read_physics_list(root, scene)) return error;
  return bind_physics_materials(root, scene);
}

}  // namespace palpate
