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
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/textures.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using MaybeError = std::optional<Error>;

constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
constexpr const char* kPhysicsMaterials = "/extensions/KHR_physics_rigid_bodies/physicsMaterials";
constexpr const char* kHapticNames[] = {"MPEG_haptic_material", "MPEG_material_haptic"};

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

// --- What is not known ---------------------------------------------------------------------------

// One warning for all properties of an object that are not these and not of every glTF object.
void warn_about_others(const Json& object, const std::string& element,
                       std::span<const char* const> known, std::vector<std::string>& warnings) {
  constexpr const char* kOfEvery[] = {"name", "extensions", "extras"};
  std::size_t count = 0;
  std::string first;
  for (const auto& [name, value] : object.items()) {
    const auto is_name = [&text = name](const char* k) { return text == k; };
    if (std::any_of(known.begin(), known.end(), is_name)) continue;
    if (std::any_of(std::begin(kOfEvery), std::end(kOfEvery), is_name)) continue;
    if (++count == 1) first = in_quotes(name);
  }
  if (count == 0) return;
  const std::string more = count > 1 ? " and " + std::to_string(count - 1) + " more" : "";
  warnings.push_back(element + ": has " + first + more + ", which nothing is made of");
}

// --- Lists of extensions -------------------------------------------------------------------------

// The array that an extension of the root has; null if the asset has none.
Result<const Json*> extension_list(const Json& root, const char* extension, const char* name) {
  const Json* none = nullptr;
  const auto object = find_extension(root, "", extension);
  if (!object) return object.error();
  if (!*object) return none;
  const auto list = (*object)->find(name);
  if (list == (*object)->end()) return none;
  const std::string element = std::string("/extensions/") + extension + "/" + name;
  if (!list->is_array()) return gltf_expected(element, *list, "an array");
  if (list->size() > kMaxGltfHapticMaterials) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      "has " + std::to_string(list->size()) + " elements; at most " +
                          std::to_string(kMaxGltfHapticMaterials) + " are read");
  }
  return &*list;
}

// --- Physics materials ---------------------------------------------------------------------------

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
  std::optional<std::uint32_t> material;     // in physicsMaterials
  std::optional<std::size_t> geometry_node;  // in /nodes
};

// What a node's collider says; nothing said is an empty one.
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
    first_disagreement = gltf_element("nodes", node) + ": its collider gives " +
                         gltf_element("nodes", known->first) + " the physics material " +
                         std::to_string(*collider->material) +
                         "; it keeps that of an earlier one, " + std::to_string(known->second);
  }
  if (disagreements > 1) {
    first_disagreement +=
        "; " + std::to_string(disagreements - 1) + " further colliders disagree like it";
  }
  if (disagreements > 0) scene.notes.push_back(first_disagreement);
  // Parents come before their children in the tree.
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

// --- Haptic materials ----------------------------------------------------------------------------

struct HapticList {
  std::string element;
  const Json* list = nullptr;  // null if the asset has none
};

// That of the present name goes before that of the older one.
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
                        "brings the maps of its material to more than " +
                            std::to_string(kMaxGltfHapticMaps) + ", the most that are read");
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

// --- Variants ------------------------------------------------------------------------------------

}  // namespace

// They change looks, so what is wrong with them is no reason to refuse the file.
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

MaybeError read_physics_materials(const Json& root, SceneDescription& scene) {
  if (auto error = read_physics_list(root, scene)) return error;
  return bind_physics_materials(root, scene);
}

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

// Whether the overrides make triangles without a material flat. Those of a material that has this
// name in the file are not for them.
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
