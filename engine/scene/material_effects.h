#pragma once

// What a material declares, turned into the effects that it is felt by, and a report of what became
// of each value.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"
#include "haptics/effects/effect_program.h"
#include "io/material_description.h"

namespace palpate {

// A value that was taken.
struct HonouredParameter {
  std::string key;
  MaterialValue value;  // as given, in `unit`
  std::string unit;     // "" for none
  std::string source;   // "extras.palpate", "KHR_physics_rigid_bodies", "MPEG_haptic_material",
                        // "glTF" or "override"
  std::string element;  // JSON path, or "`SceneSettings::overrides` NAME.key"
  bool is_off = false;  // it says that there is no such effect
};

// A value that was needed and not given.
struct DefaultedParameter {
  std::string key;
  MaterialValue value;
  std::string unit;
};

// What nothing was made of.
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

// Everything that has a say in how some triangles feel.
struct MaterialSources {
  const MaterialDescription* material;  // an empty one for triangles without a material
  const PhysicsMaterialDescription* physics = nullptr;  // of the node, if there is one
  std::string physics_element = {};                     // its JSON path
  const HapticMaterialDescription* haptic = nullptr;    // of the mesh, if there is one
  double scale = 1.0;                                   // of the scene: lengths are times this
};

struct MaterialEffects {
  // One for each effect that is called for, by number. Pointers in the parameters are null.
  std::vector<EffectProgramBuilder::Entry> entries;
  bool is_solid = true;  // false: there is only the medium inside
  MaterialReport report;

  const EffectProgramBuilder::Entry* entry(std::string_view effect) const;
  std::vector<std::string> effect_names() const;  // sorted
};

// Of the sources of a value, material (whose overrides io has put in place already) goes before
// physics, and both before the defaults. An effect is called for if one of its keys of the role
// kCallsFor is given and not zero, or, if it has none, if that of the role kRequired is given.
// Besides: a friction coefficient that a physics material does not write is kPhysicsFriction, or
// that of the other one where the two would contradict each other. Without a physics material one
// coefficient alone is the other one, too, and a friction map without any gives the coefficients
// itself; a vibrotactileTexture without textureHeight carves kDefaultTextureHeight_m.
//
// An Error names the material, the element and what was expected: a value of the wrong type, out
// of range or no choice; values that contradict each other or lack another one; an effect that is
// not in this build; a key of --material that is not known. Other keys that are not known, and maps
// that nothing uses, are no error but reported: those of an effect that is off as honoured, with
// is_off. Thread-safe.
Result<MaterialEffects> material_effects(const MaterialSources& sources);

inline constexpr double kMapFriction = 1.0;  // the map alone gives the coefficients
inline constexpr double kDefaultTextureHeight_m = 1e-4;

// The key that files may give and no effect has.
inline constexpr std::string_view kSolidKey = "solid";

// A number of compiled_effects(), or none if the effect is not in this build.
std::optional<std::uint16_t> effect_number(std::string_view name);

// What the effects of the project call their parameters, whether they are in this build or not.
struct EffectKeyName {
  std::string_view key;
  std::string_view effect;
  bool zero_is_none = true;  // 0 calls for nothing
};
std::span<const EffectKeyName> effect_key_names();

}  // namespace palpate
