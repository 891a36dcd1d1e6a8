#pragma once

// Turns the declarations of a material into effects, and reports which values were applied, which
// were set by default and which were ignored.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"
#include "haptics/effects/effect_keys.h"
#include "haptics/effects/effect_program.h"
#include "io/material_description.h"

namespace palpate {

// A declared value that was applied.
struct HonouredParameter {
  std::string key;
  MaterialValue value;  // as declared, in `unit`
  std::string unit;     // "" for a value without a unit
  std::string source;   // "extras.palpate", "KHR_physics_rigid_bodies", "MPEG_haptic_material",
                        // "glTF" or "override"
  std::string element;  // JSON path, or "`SceneSettings::overrides` NAME.key"
  bool is_off = false;  // true: the value (for example 0) switches its effect off
};

// A default value, used because a needed value was not declared.
struct DefaultedParameter {
  std::string key;
  MaterialValue value;
  std::string unit;
};

// A declared value that was ignored.
struct IgnoredParameter {
  std::string key;
  MaterialValue value;
  std::string element;
  std::string why;
};

struct MaterialReport {
  std::vector<HonouredParameter> honoured;
  std::vector<DefaultedParameter> defaulted;
  std::vector<IgnoredParameter> not_understood;

  bool empty() const { return honoured.empty() && defaulted.empty() && not_understood.empty(); }
};

// All declarations that affect the contact forces of some triangles.
struct MaterialSources {
  const MaterialDescription* material;  // an empty description for triangles without a material
  const PhysicsMaterialDescription* physics = nullptr;  // physics material of the node; null: none
  std::string physics_element = {};                     // JSON path of `physics`
  const HapticMaterialDescription* haptic = nullptr;    // haptic material of the mesh; null: none
  double scale = 1.0;  // scale of the scene; multiplies all lengths
};

struct MaterialEffects {
  // One entry for each active effect, in the order of compiled_effects(). Pointers in the
  // parameters are null.
  std::vector<EffectProgramBuilder::Entry> entries;
  bool is_solid = true;  // false: the triangles bound a medium and cannot be touched
  MaterialReport report;

  const EffectProgramBuilder::Entry* entry(std::string_view effect) const;
  std::vector<std::string> effect_names() const;  // sorted
};

// Values of the material take precedence over values of the physics material; both take precedence
// over the defaults. (io has already replaced values of the material by their overrides.) An effect
// is active if one of its keys with the role kDeclares is given and not zero. An effect without
// such a key is active if its key with the role kRequired is given.
//
// Defaults:
// - A friction coefficient that a physics material leaves out is kPhysicsFriction. If the static
//   coefficient would then be less than the dynamic one, the default is replaced by the value of
//   the other coefficient.
// - Without a physics material, a single coefficient serves as both the static and the dynamic one.
// - If a friction map is given without a coefficient, both coefficients are kMapFriction.
// - If a vibrotactileTexture is given without textureHeight, the height is kDefaultTextureHeight_m.
//
// Errors name the material and the element, and state the expected value. The causes are: a value
// that has the wrong type, is out of range or is not one of the choices; values that contradict
// each other; a value without another value that it requires; an effect that is not in this build;
// an unknown key in an override (--material). Unknown keys in a file and unused maps are reported
// as not understood, without an error. If an effect is off, its maps are reported as honoured, and
// is_off is set. Thread-safe.
Result<MaterialEffects> material_effects(const MaterialSources& sources);

inline constexpr double kMapFriction = 1.0;  // 1: the map contains the coefficients themselves
inline constexpr double kDefaultTextureHeight_m = 1e-4;

// A material key that belongs to no effect.
inline constexpr std::string_view kSolidKey = "solid";

// The index of an effect in compiled_effects(); no value if the effect is not in this build.
std::optional<std::uint16_t> effect_number(std::string_view name);

}  // namespace palpate
