#pragma once

// What a file says its surfaces feel like, as it says it. What becomes of it is the engine's part.

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
  // Red, green and blue of each pixel, row by row from the top; 0 to 65535. Values of 8 bits are
  // times 257.
  std::vector<std::uint16_t> rgb;
};

// What lies beyond the edges of an image, in one direction: the sampler of glTF.
enum class TextureWrap { kRepeat, kClamp, kMirror };

// A texture as a material refers to it. Its image is decoded only if it is called for, see
// texture_map() and friction_map().
struct TextureReference {
  std::uint32_t texture = 0;           // in /textures of the file
  std::optional<std::uint32_t> image;  // in /images; none if only an extension knows the image
  std::uint32_t tex_coord = 0;         // n of TEXCOORD_n; KHR_texture_transform may override it
  double scale = 1.0;                  // of a normal texture: of x and y of its normals; no unit
  // KHR_texture_transform: texture coordinates are scaled, then turned, then moved.
  std::array<double, 2> uv_offset = {0.0, 0.0};
  double uv_rotation_rad = 0.0;
  std::array<double, 2> uv_scale = {1.0, 1.0};
  TextureWrap wrap_u = TextureWrap::kRepeat;
  TextureWrap wrap_v = TextureWrap::kRepeat;
  std::optional<std::uint32_t> pixels = {};  // index into SceneDescription::images; if called for
};

// Numbers are in the units that the file means; nothing is known about the key here.
using MaterialValue = std::variant<double, bool, std::string, std::vector<double>>;

struct MaterialParameter {
  std::string key;  // "stiffness"; "texture.amplitude" for an entry of the object texture
  MaterialValue value;
  std::string element;  // where it is from: its JSON path, or "`SceneSettings::overrides` NAME.key"
};

// A parameter given beside the file, as SceneSettings::overrides does. It goes before what the
// file says.
struct MaterialOverride {
  std::string material;  // MaterialDescription::name, or kDefaultMaterialName
  std::string key;
  std::string value;  // JSON, else a plain text
};

// What an override calls the triangles without a material, if no material has this name.
inline constexpr const char* kDefaultMaterialName = "default";

// A glTF material and its extras.palpate; or another part of a file that has such extras.
struct MaterialDescription {
  std::string name;                           // "material 3" when the file gives none
  std::string element;                        // its JSON path, "/materials/3"
  std::vector<MaterialParameter> parameters;  // in the order of their keys
  std::optional<TextureReference> normal_texture;
};

// How a value is made of those of two bodies in contact. A device has no material, so this matters
// only to whoever gives it one.
enum class CombineMode { kAverage, kMinimum, kMaximum, kMultiply };

// What KHR_physics_rigid_bodies gives a coefficient of friction that is not written.
inline constexpr double kPhysicsFriction = 0.6;

// An entry of physicsMaterials of KHR_physics_rigid_bodies. The values have no unit; they are
// finite and not negative; none: not written.
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
  std::string name;             // "haptic material 3" when the file gives none
  std::vector<HapticMap> maps;  // those of one property together, in file order
};

// The map whose values are the haptic texture of triangles of this material in a mesh of this
// haptic material (null: of none). The first vibrotactileTexture of the haptic material goes before
// the normal texture of the material, which counts only beside the parameter "textureHeight". Null
// if there is neither, or if that parameter is the number 0. Thread-safe, as the next two.
const TextureReference* texture_map(const MaterialDescription& material,
                                    const HapticMaterialDescription* haptic);

// The map by which friction varies over a mesh of this haptic material: its first friction map, or
// null.
const TextureReference* friction_map(const HapticMaterialDescription* haptic);

// True if the parameter "textureHeight" says that there is no haptic texture: it is the number 0.
bool is_flat(const MaterialDescription& material);

}  // namespace palpate
