#include "io/gltf/materials.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/haptic_materials.h"
#include "io/gltf/json.h"
#include "io/gltf/textures.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

// --- Materials -----------------------------------------------------------------------------------

Result<MaterialDescription> read_material(const Json& root, std::size_t id, PalpateExtras& extras) {
  MaterialDescription material;
  material.element = gltf_element("materials", id);
  const Json& object = root["materials"][id];
  if (!object.is_object()) return gltf_expected(material.element, object, "an object");
  if (auto error = read_text(object, material.element, "name", material.name)) return *error;
  if (material.name.empty()) material.name = "material " + std::to_string(id);
  const auto normal = object.find("normalTexture");
  if (normal != object.end()) {
    const std::string element = material.element + "/normalTexture";
    auto reference = read_texture_reference(root, *normal, element);
    if (!reference) return reference.error();
    if (auto error = read_number(*normal, element, "scale", reference->scale)) return *error;
    material.normal_texture = *reference;
  }
  if (auto error = extras.read(object, material.element, material.parameters)) return *error;
  return material;
}

// --- Overrides -----------------------------------------------------------------------------------

bool any_without_material(const SceneDescription& scene) {
  for (const MeshDescription& mesh : scene.meshes) {
    for (const MaterialRun& run : mesh.material_runs) {
      if (!run.material) return true;
    }
  }
  return false;
}

// "no triangle has the material "x"; there are "a", "b" and 3 more"
Error unknown_material(const std::string& name, const std::string& element,
                       const std::set<std::string>& known) {
  constexpr std::size_t kMaxNames = 8;
  std::string names;
  std::size_t count = 0;
  for (const std::string& other : known) {
    if (++count > kMaxNames) break;
    names += (count == 1 ? "" : ", ") + in_quotes(other);
  }
  if (known.size() > kMaxNames) {
    names += " and " + std::to_string(known.size() - kMaxNames) + " more";
  }
  return gltf_error(
      ErrorCode::kInvalidArgument, element,
      "no triangle of the scene has a material " + in_quotes(name) + "; there are " + names,
      std::string(kDefaultMaterialName) + " is for triangles without a material");
}

}  // namespace

// --- Variants ------------------------------------------------------------------------------------

// Variants affect the appearance only, so an invalid one does not make the file an error.
void note_variants(const Json& root, std::vector<std::string>& notes) {
  constexpr std::size_t kMaxNames = 8;
  constexpr const char* kName = "KHR_materials_variants";
  const auto extension = find_extension(root, "", kName);
  if (!extension || !*extension) return;
  const auto variants = (*extension)->find("variants");
  if (variants == (*extension)->end() || !variants->is_array() || variants->empty()) return;
  std::string names;
  for (std::size_t i = 0; i < variants->size() && i < kMaxNames; ++i) {
    const Json& variant = (*variants)[i];
    const auto name = variant.is_object() ? variant.find("name") : variant.end();
    const bool has_name = name != variant.end() && name->is_string();
    names += (i == 0 ? "" : ", ") +
             (has_name ? in_quotes(name->get<std::string>()) : "variant " + std::to_string(i));
  }
  if (variants->size() > kMaxNames) {
    names += " and " + std::to_string(variants->size() - kMaxNames) + " more";
  }
  notes.push_back(std::string("/extensions/") + kName +
                  ": triangles have their default materials, not those of the variants " + names);
}

// --- Interface -----------------------------------------------------------------------------------

Result<GltfMaterials> GltfMaterials::open(const Json& root, PalpateExtras& extras,
                                          std::span<const MaterialOverride> overrides) {
  GltfMaterials materials(root, extras);
  for (const MaterialOverride& setting : overrides) {
    auto parameter = parameter_of(setting);
    if (!parameter) return parameter.error();
    materials.overrides_.push_back({setting.material, std::move(*parameter)});
  }
  auto haptic_materials = read_haptic_materials(root, materials.warnings_);
  if (!haptic_materials) return haptic_materials.error();
  materials.haptic_materials_ = std::move(*haptic_materials);
  materials.find_haptic_maps();
  materials.is_default_flat_ = materials.is_default_flat();
  return materials;
}

void GltfMaterials::find_haptic_maps() {
  for (HapticMaterialDescription& haptic : haptic_materials_) {
    const TextureReference* texture = texture_map({}, &haptic);
    const TextureReference* friction = friction_map(&haptic);
    KnownHaptic known;
    for (HapticMap& map : haptic.maps) {
      if (&map.texture == texture) known.texture = &map.texture;
      if (&map.texture == friction) known.friction = &map.texture;
    }
    known_haptics_.push_back(known);
  }
}

// Whether the overrides make triangles without a material flat. If a material of the file has the
// default name, the overrides apply to that material instead.
bool GltfMaterials::is_default_flat() const {
  const auto found = root_->find("materials");
  static const Json kNone = Json::array();
  const bool is_list = found != root_->end() && found->is_array();
  const Json& materials = is_list ? *found : kNone;
  for (const Json& material : materials) {
    const auto name = material.is_object() ? material.find("name") : material.end();
    if (name != material.end() && *name == kDefaultMaterialName) return false;
  }
  MaterialDescription none;
  for (const Override& setting : overrides_) {
    if (setting.material == kDefaultMaterialName) set_parameter(setting.parameter, none.parameters);
  }
  return is_flat(none);
}

Result<std::uint32_t> GltfMaterials::index_of(std::uint32_t id) {
  const auto [known, is_new] = indices_.emplace(id, static_cast<std::uint32_t>(materials_.size()));
  if (!is_new) return known->second;
  auto material = read_material(*root_, id, *extras_);
  if (!material) return material.error();
  apply_overrides(*material);
  known_materials_.push_back({texture_map(*material, nullptr) != nullptr, is_flat(*material)});
  materials_.push_back(std::move(*material));
  return known->second;
}

GltfMaterials::Maps GltfMaterials::call_maps(std::optional<std::uint32_t> material,
                                             std::optional<std::uint32_t> haptic) {
  Maps maps;
  if (haptic) {
    KnownHaptic& known = known_haptics_[*haptic];
    const bool flat = material ? known_materials_[*material].is_flat : is_default_flat_;
    maps = {flat ? nullptr : known.texture, known.friction};
    known.texture_called = known.texture_called || maps.texture;
    known.friction_called = known.friction_called || maps.friction;
  }
  if (maps.texture == nullptr && material && known_materials_[*material].has_map) {
    known_materials_[*material].called = true;
    maps.texture = &*materials_[*material].normal_texture;
  }
  return maps;
}

MaybeError GltfMaterials::decode_maps(GltfImages& images) {
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    if (!known_materials_[i].called) continue;
    const std::string wanted_by = "the textureHeight of " + materials_[i].element;
    if (auto error = images.decode(*materials_[i].normal_texture, wanted_by)) return error;
  }
  for (std::size_t i = 0; i < known_haptics_.size(); ++i) {
    const KnownHaptic& known = known_haptics_[i];
    for (TextureReference* map : {known.texture_called ? known.texture : nullptr,
                                  known.friction_called ? known.friction : nullptr}) {
      if (map == nullptr) continue;
      const std::string wanted_by = "a map of haptic material " + std::to_string(i);
      if (auto error = images.decode(*map, wanted_by)) return error;
    }
  }
  return std::nullopt;
}

void GltfMaterials::apply_overrides(MaterialDescription& material) {
  for (Override& setting : overrides_) {
    if (setting.material != material.name) continue;
    set_parameter(setting.parameter, material.parameters);
    setting.used = true;
  }
}

MaybeError GltfMaterials::finish(SceneDescription& scene) {
  scene.materials = std::move(materials_);
  scene.haptic_materials = std::move(haptic_materials_);
  std::move(warnings_.begin(), warnings_.end(), std::back_inserter(scene.warnings));
  if (overrides_.empty()) return std::nullopt;
  const bool has_default = any_without_material(scene);
  if (has_default) add_default(scene);
  for (const Override& setting : overrides_) {
    if (setting.used) continue;
    std::set<std::string> known;
    for (const MaterialDescription& material : scene.materials) known.insert(material.name);
    if (has_default) known.insert(kDefaultMaterialName);
    return unknown_material(setting.material, setting.parameter.element, known);
  }
  return std::nullopt;
}

void GltfMaterials::add_default(SceneDescription& scene) {
  for (const MaterialDescription& material : scene.materials) {
    if (material.name == kDefaultMaterialName) return;
  }
  MaterialDescription material{kDefaultMaterialName, "default material", {}, {}};
  apply_overrides(material);
  if (material.parameters.empty()) return;
  const auto index = static_cast<std::uint32_t>(scene.materials.size());
  scene.materials.push_back(std::move(material));
  for (MeshDescription& mesh : scene.meshes) {
    for (MaterialRun& run : mesh.material_runs) {
      if (!run.material) run.material = index;
    }
  }
}

}  // namespace palpate
