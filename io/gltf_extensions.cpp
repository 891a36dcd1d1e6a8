#include "io/gltf_extensions.h"

#include <algorithm>
#include <string_view>

#include <nlohmann/json.hpp>

#include "io/gltf_error.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMeshQuantization = "KHR_mesh_quantization";
// These change looks, sound, motion or metadata, not the triangles at rest.
constexpr std::string_view kHarmlessPrefixes[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                                  "MSFT_texture_"};
constexpr std::string_view kHarmless[] = {
    "KHR_mesh_quantization",   "KHR_lights_punctual",
    "EXT_lights_image_based",  "KHR_animation_pointer",
    "KHR_audio_emitter",       "KHR_interactivity",
    "KHR_node_hoverability",   "KHR_node_selectability",
    "KHR_xmp_json_ld",         "KHR_xmp",
    "EXT_mesh_features",       "EXT_instance_features",
    "EXT_structural_metadata", "EXT_mesh_manifold",
    "FB_ngon_encoding",        "MPEG_haptic_material",
    "MPEG_material_haptic",    "KHR_physics_rigid_bodies",
    "KHR_implicit_shapes",
};

struct Unsupported {
  std::string_view name;
  std::string_view hint;             // when required
  std::string_view without_support;  // when only used; empty: nothing is lost
};

constexpr Unsupported kUnsupported[] = {
    {"KHR_draco_mesh_compression", "export the asset without Draco compression", ""},
    {"EXT_meshopt_compression", "export the asset without meshopt compression", ""},
    {"KHR_meshopt_compression", "export the asset without meshopt compression", ""},
    {"EXT_mesh_gpu_instancing", "export the instances as nodes",
     "a node that it instances appears once"},
    {"KHR_node_visibility", "delete the hidden nodes", "hidden nodes are read like visible ones"},
};

bool is_harmless(std::string_view name) {
  return std::any_of(std::begin(kHarmlessPrefixes), std::end(kHarmlessPrefixes),
                     [&](std::string_view prefix) { return name.starts_with(prefix); }) ||
         std::find(std::begin(kHarmless), std::end(kHarmless), name) != std::end(kHarmless);
}

const Unsupported* find_unsupported(std::string_view name) {
  const auto* found = std::find_if(std::begin(kUnsupported), std::end(kUnsupported),
                                   [&](const Unsupported& entry) { return entry.name == name; });
  return found == std::end(kUnsupported) ? nullptr : found;
}

Result<std::vector<std::string>> names_in(const Json& root, const char* list) {
  std::vector<std::string> names;
  const auto found = root.find(list);
  if (found == root.end()) return names;
  const std::string element = std::string("/") + list;
  if (!found->is_array()) return gltf_invalid(element, "is not an array");
  for (const Json& name : *found) {
    if (!name.is_string()) {
      return gltf_invalid(element + "/" + std::to_string(names.size()), "is not a string");
    }
    names.push_back(name.get<std::string>());
  }
  return names;
}

Error unsupported_required(std::size_t index, const std::string& name) {
  const Unsupported* known = find_unsupported(name);
  return gltf_error(ErrorCode::kUnsupported, gltf_element("extensionsRequired", index),
                    "requires the extension " + gltf_quoted(name) + ", which is not supported",
                    known ? std::string(known->hint) : "export the asset without it");
}

void warn_about(const std::string& name, std::vector<std::string>& warnings) {
  if (is_harmless(name)) return;
  const Unsupported* known = find_unsupported(name);
  if (known && known->without_support.empty()) return;
  warnings.push_back("/extensionsUsed: " + gltf_quoted(name) + " is ignored: " +
                     (known ? std::string(known->without_support) : "it is not known"));
}

// "2.0" -> {2, 0}
std::optional<std::pair<int, int>> parsed_version(const Json& text) {
  if (!text.is_string()) return std::nullopt;
  const auto& version = text.get_ref<const std::string&>();
  const std::size_t dot = version.find('.');
  if (dot == 0 || dot == std::string::npos || dot + 1 == version.size() || version.size() > 8 ||
      version.find_first_not_of("0123456789.") != std::string::npos ||
      version.find('.', dot + 1) != std::string::npos) {
    return std::nullopt;
  }
  return std::pair(std::stoi(version.substr(0, dot)), std::stoi(version.substr(dot + 1)));
}

}  // namespace

std::optional<Error> check_asset_version(const Json& root) {
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object() || !asset->contains("version")) {
    return gltf_error(ErrorCode::kNotGltf, "/asset/version", "is missing; expected \"2.0\"",
                      "not a glTF asset, or one of glTF 1.0: convert it to 2.0");
  }
  for (const char* name : {"version", "minVersion"}) {
    const auto text = asset->find(name);
    if (text == asset->end()) continue;
    const std::string element = std::string("/asset/") + name;
    const auto version = parsed_version(*text);
    if (!version) return gltf_invalid(element, "is not a version such as \"2.0\"");
    const bool is_minimum = element == "/asset/minVersion";
    if (version->first != 2 || (is_minimum && version->second > 0)) {
      return gltf_error(ErrorCode::kUnsupported, element,
                        "is " + gltf_quoted(text->get<std::string>()) + "; expected 2.0",
                        "convert the asset to glTF 2.0");
    }
  }
  return std::nullopt;
}

Result<GltfExtensions> check_extensions(const Json& root) {
  const auto required = names_in(root, "extensionsRequired");
  if (!required) return required.error();
  const auto used = names_in(root, "extensionsUsed");
  if (!used) return used.error();
  GltfExtensions extensions;
  for (std::size_t i = 0; i < required->size(); ++i) {
    const std::string& name = (*required)[i];
    if (!is_harmless(name)) return unsupported_required(i, name);
    extensions.mesh_quantization |= name == kMeshQuantization;
  }
  for (const std::string& name : *used) {
    warn_about(name, extensions.warnings);
    extensions.mesh_quantization |= name == kMeshQuantization;
  }
  return extensions;
}

}  // namespace palpate
