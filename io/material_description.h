#pragma once

// The haptic materials that a file declares, uninterpreted. The engine interprets them.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace palpate {

// The pixels of an image.
struct ImageDescription {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  // Red, green and blue of each pixel, row by row from the top; 0 to 65535. 8-bit values are
  // multiplied by 257.
  std::vector<std::uint16_t> rgb;
};

// The continuation of an image beyond its edges in one direction, as in a glTF sampler.
enum class TextureWrap { kRepeat, kClamp, kMirror };

// A reference from a material to a texture. The image of the texture is decoded only if
// texture_map() or friction_map() selects the reference.
struct TextureReference {
  std::uint32_t texture = 0;  // index into /textures of the file
  std::optional<std::uint32_t>
      image;                    // index into /images; absent if only an extension names the image
  std::uint32_t tex_coord = 0;  // n of TEXCOORD_n; KHR_texture_transform may override it
  double scale = 1.0;           // of a normal texture: factor of the x and y of its normals
  // KHR_texture_transform: texture coordinates are scaled, then rotated, then translated.
  std::array<double, 2> uv_offset = {0.0, 0.0};
  double uv_rotation_rad = 0.0;
  std::array<double, 2> uv_scale = {1.0, 1.0};
  TextureWrap wrap_u = TextureWrap::kRepeat;
  TextureWrap wrap_v = TextureWrap::kRepeat;
  std::optional<std::uint32_t> pixels = {};  // index into SceneDescription::images, if decoded
};

// A value as the file states it; its unit depends on the key, which is not interpreted here.
using MaterialValue = std::variant<double, bool, std::string, std::vector<double>>;

struct MaterialParameter {
  std::string key;  // "stiffness"; "texture.amplitude" for an entry of the object texture
  MaterialValue value;
  std::string element;  // JSON path, or "`SceneSettings::overrides` NAME.key" of an override
};

// A parameter set outside the file, as in SceneSettings::overrides. It takes precedence over the
// file.
struct MaterialOverride {
  std::string material;  // MaterialDescription::name, or kDefaultMaterialName
  std::string key;
  std::string value;  // JSON; if it is not JSON, plain text
};

// The material name with which an override addresses the triangles without a material, unless a
// material has this name.
inline constexpr const char* kDefaultMaterialName = "default";

// A glTF material, or another element that has extras.palpate, together with these extras.
struct MaterialDescription {
  std::string name;                           // "material 3" if the file gives no name
  std::string element;                        // its JSON path, "/materials/3"
  std::vector<MaterialParameter> parameters;  // in the order of their keys
  std::optional<TextureReference> normal_texture;
};

// The rule by which the values of two bodies in contact are combined. The device has no material,
// so the mode is not used in this engine.
enum class CombineMode { kAverage, kMinimum, kMaximum, kMultiply };

// The default coefficient of friction of KHR_physics_rigid_bodies.
inline constexpr double kPhysicsFriction = 0.6;

// An entry of physicsMaterials of KHR_physics_rigid_bodies. The values are dimensionless, finite
// and not negative; a value that the file does not state is absent.
struct PhysicsMaterialDescription {
  std::optional<double> static_friction = {};
  std::optional<double> dynamic_friction = {};
  std::optional<double> restitution = {};
  CombineMode friction_combine = CombineMode::kAverage;
  CombineMode restitution_combine = CombineMode::kAverage;
};

// A texture that holds haptic values.
struct HapticMap {
  std::string property;  // "stiffness", "friction", "vibrotactileTexture", ...
  std::string type;      // "High_Resolution", "Low_Resolution", "Reference" or "Other"
  TextureReference texture;
  std::string element;  // its JSON path
};

// An entry of materials of MPEG_haptic_material.
struct HapticMaterialDescription {
  std::string name;             // "haptic material 3" if the file gives no name
  std::vector<HapticMap> maps;  // grouped by property, each group in file order
};

// The map of the haptic texture for triangles of this material in a mesh with this haptic material
// (null: none). The first vibrotactileTexture of the haptic material takes precedence over the
// material's normal texture, which is used only together with the parameter "textureHeight".
// Returns null if neither texture applies or if "textureHeight" is the number 0. This function and
// the next two are thread-safe.
const TextureReference* texture_map(const MaterialDescription& material,
                                    const HapticMaterialDescription* haptic);

// The map of the friction over a mesh with this haptic material: its first friction map. Returns
// null if the haptic material has no friction map or if haptic is null.
const TextureReference* friction_map(const HapticMaterialDescription* haptic);

// True if the parameter "textureHeight" is the number 0, which disables the haptic texture.
bool is_flat(const MaterialDescription& material);

}  // namespace palpate
