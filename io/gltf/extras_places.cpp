#include "io/gltf/extras_places.h"

#include <algorithm>
#include <map>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

const char* type_of(const Json& value) {
  if (value.is_string()) return "a text";
  if (value.is_array()) return "a list";
  if (value.is_boolean()) return "true or false";
  return value.is_null() ? "null" : "a number";
}

}  // namespace

unsigned owner_of(ExtrasElementKind kind) {
  switch (kind) {
    case ExtrasElementKind::kMaterial:
      return kOfMaterial;
    case ExtrasElementKind::kScene:
      return kOfScene;
    case ExtrasElementKind::kNode:
      return kOfNode;
    default:
      return 0;
  }
}

std::vector<std::size_t> ExtrasPlaces::materials_of(const ExtrasElement& element) const {
  constexpr std::size_t kEnough = 2;
  std::vector<std::size_t> found;
  const tinygltf::Model& model = asset_.model;
  std::size_t mesh = element.index;
  if (element.kind == ExtrasElementKind::kNode) {
    if (mesh >= model.nodes.size() || model.nodes[mesh].mesh < 0) return found;
    mesh = static_cast<std::size_t>(model.nodes[mesh].mesh);
  } else if (element.kind != ExtrasElementKind::kMesh) {
    return found;
  }
  if (mesh >= model.meshes.size()) return found;
  const auto& primitives = model.meshes[mesh].primitives;
  for (std::size_t i = 0; i < primitives.size() && found.size() < kEnough; ++i) {
    if (primitives[i].material < 0 || (element.primitive && *element.primitive != i)) continue;
    const auto id = static_cast<std::size_t>(primitives[i].material);
    if (std::find(found.begin(), found.end(), id) == found.end()) found.push_back(id);
  }
  return found;
}

// "/materials/3/extras/palpate (material "wood")"
std::string ExtrasPlaces::material_place(std::size_t id) const {
  std::string text = gltf_element("materials", id, "extras/palpate");
  const Json& material = asset_.json["materials"][id];
  const auto name = material.is_object() ? material.find("name") : material.end();
  if (name == material.end() || !name->is_string()) return text;
  return text + " (material " + in_quotes(name->get<std::string>()) + ")";
}

// Where keys with these owners belong that were written at the element.
std::string ExtrasPlaces::place_of(unsigned owners, const ExtrasElement& element,
                                   bool has_medium) const {
  const bool is_node = element.kind == ExtrasElementKind::kNode;
  if ((owners & owner_of(element.kind)) && !(is_node && !has_medium && (owners & kOfMaterial))) {
    if (element.kind == ExtrasElementKind::kMaterial) return material_place(element.index);
    const std::string own =
        gltf_element(is_node ? "nodes" : "scenes", element.index, "extras/palpate");
    return is_node && !has_medium ? own + ", together with the key medium" : own;
  }
  if (owners & kOfMaterial) {
    const auto materials = materials_of(element);
    if (materials.empty()) return "extras.palpate of a material";
    if (materials.size() == 1) return material_place(materials.front());
    return "extras.palpate of the materials, such as " + material_place(materials.front());
  }
  if ((owners & kOfScene) && scene_) {
    return gltf_element("scenes", *scene_, "extras/palpate");
  }
  return "extras.palpate of " + owners_text(owners);
}

std::string ExtrasPlaces::belongs(const KeyMatch& match, const ExtrasElement& element,
                                  bool has_medium) const {
  const std::string name = match.likeness == KeyLikeness::kSame
                               ? match.key->name
                               : "the nearest key, " + match.key->name + ",";
  return name + " belongs in " + place_of(match.key->owners, element, has_medium);
}

std::string ExtrasPlaces::belongs(const Json& group, const ExtrasElement& element, bool is_group) {
  if (is_group && !group.is_object()) {
    return std::string("it is ") + type_of(group) +
           "; expected an object such as {\"stiffness\": 400} in " +
           place_of(kOfMaterial, element, false);
  }
  constexpr std::size_t kMostKeys = 64;
  constexpr std::size_t kMostNames = 3;
  const bool has_medium = group.contains(kMediumKey);
  std::map<std::string, std::pair<std::size_t, std::string>> of_place;  // count and names
  std::size_t looked_at = 0;
  for (const auto& [key, value] : group.items()) {
    if (!is_group || ++looked_at > kMostKeys) break;
    const auto match = names_.find(key, owner_of(element.kind), allowance_);
    if (!match) continue;
    auto& [count, names] = of_place[place_of(match->key->owners, element, has_medium)];
    if (++count <= kMostNames) names += (count == 1 ? "" : ", ") + match->key->name;
  }
  std::string text;
  for (const auto& [place, keys] : of_place) {
    const auto& [count, names] = keys;
    text += (text.empty() ? "" : "; ") + names;
    if (count > kMostNames) text += " and " + std::to_string(count - kMostNames) + " more";
    text += (count == 1 ? " belongs in " : " belong in ") + place;
  }
  if (!text.empty()) return text;
  return "haptic values belong in " + place_of(kOfMaterial, element, false);
}

}  // namespace palpate
