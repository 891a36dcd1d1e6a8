#include "io/gltf/haptic_materials.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/material_lists.h"
#include "io/gltf/textures.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kHapticNames[] = {"MPEG_haptic_material", "MPEG_material_haptic"};

struct HapticList {
  std::string element;
  const Json* list = nullptr;  // null if the asset has none
};

// The list under the current name takes precedence over the list under the older name.
Result<HapticList> find_haptic_list(const Json& root) {
  for (const char* name : kHapticNames) {
    const auto list = extension_list(root, name, "materials");
    if (!list) return list.error();
    if (*list) return HapticList{std::string("/extensions/") + name + "/materials", *list};
  }
  return HapticList{std::string("/extensions/") + kHapticNames[0] + "/materials", nullptr};
}

Result<HapticMap> read_map(const Json& root, const Json& object, const std::string& element,
                           const char* property) {
  if (!object.is_object()) return gltf_expected(element, object, "an object");
  HapticMap map{property, {}, {}, element};
  for (const char* name : {"texture", "type"}) {
    if (!object.contains(name)) return gltf_invalid(element + "/" + name, "is missing");
  }
  if (auto error = read_text(object, element, "type", map.type)) return *error;
  const auto texture = read_texture_reference(root, object["texture"], element + "/texture");
  if (!texture) return texture.error();
  map.texture = *texture;
  return map;
}

Result<HapticMaterialDescription> read_haptic_material(const Json& root, const Json& object,
                                                       const std::string& element,
                                                       std::vector<std::string>& warnings) {
  constexpr const char* kProperties[] = {"stiffness",   "friction",  "vibrotactileTexture",
                                         "temperature", "vibration", "custom"};
  if (!object.is_object()) return gltf_expected(element, object, "an object");
  HapticMaterialDescription material;
  if (auto error = read_text(object, element, "name", material.name)) return *error;
  for (const char* property : kProperties) {
    const auto maps = object.find(property);
    if (maps == object.end()) continue;
    const std::string list_element = element + "/" + property;
    if (!maps->is_array()) return gltf_expected(list_element, *maps, "an array");
    if (maps->size() > kMaxGltfHapticMaps - material.maps.size()) {
      return gltf_error(ErrorCode::kLimitExceeded, list_element,
                        "raises the number of maps of its material to more than " +
                            std::to_string(kMaxGltfHapticMaps) + ", the limit");
    }
    for (std::size_t i = 0; i < maps->size(); ++i) {
      auto map = read_map(root, (*maps)[i], list_element + "/" + std::to_string(i), property);
      if (!map) return map.error();
      material.maps.push_back(std::move(*map));
    }
  }
  warn_about_others(object, element, kProperties, warnings);
  return material;
}

}  // namespace

Result<std::vector<HapticMaterialDescription>> read_haptic_materials(
    const Json& root, std::vector<std::string>& warnings) {
  std::vector<HapticMaterialDescription> materials;
  const auto found = find_haptic_list(root);
  if (!found) return found.error();
  if (!found->list) return materials;
  for (const Json& object : *found->list) {
    const std::string index = std::to_string(materials.size());
    auto material = read_haptic_material(root, object, found->element + "/" + index, warnings);
    if (!material) return material.error();
    if (material->name.empty()) material->name = "haptic material " + index;
    materials.push_back(std::move(*material));
  }
  return materials;
}

Result<std::optional<std::uint32_t>> haptic_material_of_mesh(const Json& root, std::size_t mesh) {
  const std::string mesh_element = gltf_element("meshes", mesh);
  for (const char* name : kHapticNames) {
    const auto extension = find_extension(root["meshes"][mesh], mesh_element, name);
    if (!extension) return extension.error();
    if (!*extension) continue;
    const auto found = find_haptic_list(root);
    if (!found) return found.error();
    const auto index =
        required_id(**extension, mesh_element + "/extensions/" + name, "hapticMaterialIndex",
                    found->element.c_str(), found->list ? found->list->size() : 0);
    if (!index) return index.error();
    return std::optional<std::uint32_t>(static_cast<std::uint32_t>(*index));
  }
  return std::optional<std::uint32_t>();
}

}  // namespace palpate
