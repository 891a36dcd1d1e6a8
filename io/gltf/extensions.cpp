#include "io/gltf/extensions.h"

#include <algorithm>
#include <string_view>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMeshQuantization = "KHR_mesh_quantization";
// Extensions that an asset may require. They are supported, or they affect appearance, sound,
// motion, physics or metadata but not the triangles in the rest pose. Any other name is unknown,
// whatever its prefix. Some entries may be surprising: the coarser levels of MSFT_lod are nodes
// outside the scene, and the content of EXT_mesh_primitive_restart and EXT_mesh_polygon is also
// present as plain triangles.
constexpr std::string_view kHarmless[] = {
    "ADOBE_materials_clearcoat_specular",
    "ADOBE_materials_clearcoat_tint",
    "ADOBE_materials_thin_transparency",
    "ADOBE_render_order",
    "AGI_articulations",
    "AGI_metadata",
    "AGI_stk_metadata",
    "BENTLEY_materials_line_style",
    "BENTLEY_materials_planar_fill",
    "BENTLEY_materials_point_style",
    "BENTLEY_primitive_restart",
    "CESIUM_geopose",
    "CESIUM_primitive_outline",
    "CESIUM_tile_edges",
    "CVTOOLS_unity_metadata",
    "DRACO_animation_compression",
    "EXT_animation_quantization",
    "EXT_feature_metadata",
    "EXT_geopose",
    "EXT_image_webp",
    "EXT_instance_features",
    "EXT_lights_area",
    "EXT_lights_environment",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_manifold",
    "EXT_materials_anisotropy_openpbr",
    "EXT_materials_bump",
    "EXT_materials_clearcoat_color",
    "EXT_materials_clearcoat_darkening",
    "EXT_materials_diffuse_roughness",
    "EXT_materials_dispersion",
    "EXT_materials_specular_edge_color",
    "EXT_materials_specular_openpbr",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_mesh_polygon",
    "EXT_mesh_primitive_edge_visibility",
    "EXT_mesh_primitive_restart",
    "EXT_property_animation",
    "EXT_structural_metadata",
    "EXT_texture_astc",
    "EXT_texture_astc_hdr",
    "EXT_texture_avif",
    "EXT_texture_bc6h",
    "EXT_texture_procedurals_mx_1_39",
    "EXT_texture_qoi",
    "EXT_texture_svg",
    "EXT_texture_webp",
    "FB_geometry_metadata",
    "FB_material_variants",
    "FB_materials_lightmap",
    "FB_materials_modmap",
    "FB_ngon_encoding",
    "FRAUNHOFER_materials_pbr",
    "GODOT_single_root",
    "GOOGLE_texture_basis",
    "GRIFFEL_bim_data",
    "HUBS_components",
    "INTEL_lights_sunsky",
    "KHR_animation2",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_audio_environment",
    "KHR_audio_graph",
    "KHR_behavior",
    "KHR_collision_shapes",
    "KHR_image_ktx2",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_lights",
    "KHR_lights_area",
    "KHR_lights_environment",
    "KHR_lights_ies",
    "KHR_lights_image_based",
    "KHR_lights_punctual",
    "KHR_lights_shadows",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_clearcoat_anisotropy",
    "KHR_materials_clearcoat_color",
    "KHR_materials_clearcoat_darkening",
    "KHR_materials_clearcoat_ior",
    "KHR_materials_coat",
    "KHR_materials_common",
    "KHR_materials_diffuse_roughness",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_fuzz",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_parallax_mapping",
    "KHR_materials_pbr",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_sss",
    "KHR_materials_subsurface",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_physics_rigid_bodies",
    "KHR_rigid_bodies",
    "KHR_techniques_webgl",
    "KHR_texture_basisu",
    "KHR_texture_ktx",
    "KHR_texture_procedurals",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MAXAR_collision_geometry",
    "MOZ_alt_materials",
    "MOZ_hubs_components",
    "MOZ_lightmap",
    "MPEG_animation_timing",
    "MPEG_audio_spatial",
    "MPEG_haptic",
    "MPEG_haptic_material",
    "MPEG_lights_texture_based",
    "MPEG_material_haptic",
    "MPEG_node_interactivity",
    "MPEG_scene_interactivity",
    "MPEG_texture_video",
    "MPEG_viewport_recommended",
    "MSFT_audio_emitter",
    "MSFT_collision_primitives",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_physics",
    "MSFT_rigid_bodies",
    "MSFT_texture_dds",
    "NV_Iray",
    "NV_MDL",
    "NV_materials_mdl",
    "OMI_audio_emitter",
    "OMI_audio_ogg_vorbis",
    "OMI_audio_opus",
    "OMI_collider",
    "OMI_environment_sky",
    "OMI_link",
    "OMI_personality",
    "OMI_physics_body",
    "OMI_physics_gravity",
    "OMI_physics_joint",
    "OMI_physics_shape",
    "OMI_seat",
    "OMI_spawn_point",
    "OMI_vehicle_body",
    "OMI_vehicle_hover_thruster",
    "OMI_vehicle_thruster",
    "OMI_vehicle_wheel",
    "VRM",
    "VRMC_materials_hdr_emissiveMultiplier",
    "VRMC_materials_mtoon",
    "VRMC_node_constraint",
    "VRMC_springBone",
    "VRMC_vrm",
    "VRMC_vrm_animation",
};
static_assert(std::is_sorted(std::begin(kHarmless), std::end(kHarmless)));
// Compression extensions, which are decoded.
constexpr std::string_view kCompressions[] = {"KHR_draco_mesh_compression",
                                              "EXT_meshopt_compression", "KHR_meshopt_compression"};

struct Unsupported {
  std::string_view name;
  std::string_view hint;             // if the extension is required
  std::string_view without_support;  // warning if it is only used; empty: no effect
};

constexpr Unsupported kUnsupported[] = {
    {"CESIUM_RTC", "move the nodes by its center", "the scene is read without the offset"},
    {"EXT_primitive_voxels", "export surfaces instead of voxels", "voxels are left out"},
    {"KHR_accessor_float16", "export positions as 32-bit floats", ""},
    {"KHR_accessor_float64", "export positions as 32-bit floats", ""},
    {"KHR_displacement_mapping_shared", "apply the displacement to the mesh",
     "surfaces are read without their displacement"},
    {"KHR_gaussian_splatting", "export surfaces instead of splats", "splats are left out"},
    {"KHR_gaussian_splatting_compression_spz", "export surfaces instead of splats",
     "splats are left out"},
    {"KHR_gaussian_splatting_compression_spz_2", "export surfaces instead of splats",
     "splats are left out"},
    {"MAXAR_mesh_variants", "export one variant", "the default meshes are read"},
    {"MPEG_accessor_timed", "export the geometry of one moment",
     "only the data in the file are read, no streamed data"},
};

bool is_known(std::string_view name) {
  return std::find(std::begin(kCompressions), std::end(kCompressions), name) !=
             std::end(kCompressions) ||
         std::binary_search(std::begin(kHarmless), std::end(kHarmless), name);
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
  if (found->size() > kMaxGltfExtensionNames) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      "has " + std::to_string(found->size()) + " names; at most " +
                          std::to_string(kMaxGltfExtensionNames) + " are read");
  }
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
                    "requires the extension " + in_quotes(name) + ", which is not supported",
                    known ? std::string(known->hint) : "export the asset without it");
}

void warn_about(const std::string& name, std::vector<std::string>& warnings) {
  if (is_known(name)) return;
  const Unsupported* known = find_unsupported(name);
  if (known && known->without_support.empty()) return;
  warnings.push_back("/extensionsUsed: " + in_quotes(name) + " is ignored: " +
                     (known ? std::string(known->without_support) : "it is unknown"));
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
                      "the asset is not glTF, or it is glTF 1.0: convert it to 2.0");
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
                        "is " + in_quotes(text->get<std::string>()) + "; expected 2.0",
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
    if (!is_known(name)) return unsupported_required(i, name);
    extensions.mesh_quantization |= name == kMeshQuantization;
  }
  for (const std::string& name : *used) {
    warn_about(name, extensions.warnings);
    extensions.mesh_quantization |= name == kMeshQuantization;
  }
  return extensions;
}

}  // namespace palpate
