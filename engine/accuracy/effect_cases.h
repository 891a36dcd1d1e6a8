#pragma once

// Scenes of a sphere that has effects, and of the same sphere without them: what an effect costs is
// measured between the two.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

// Every effect there is, as reports call it, in the order of PALPATE_EFFECTS.
std::span<const std::string_view> measured_effects();

struct EffectCase {
  std::string name;
  std::vector<std::string_view> effects;  // of measured_effects(), in their order
  // The effects are those of a small sphere beside it, which is not touched.
  bool is_elsewhere = false;

  bool has(std::string_view effect) const;
};

EffectCase only(std::string_view effect);     // named like the effect
EffectCase all_but(std::string_view effect);  // "all but friction"
EffectCase all_effects();                     // "all"
EffectCase effects_elsewhere();               // "elsewhere"
// The geometry of a case without its effects.
EffectCase without_effects(const EffectCase& effect_case);

// The icosphere of this radius about the origin, 20 * 4^subdivisions triangles, as a file would
// declare it; with effects of the surface, in a medium and a field where the case has these.
// Metres. Error: as Scene::compile(), for a program that was built without one of the effects.
Result<Scene> effect_scene(int subdivisions, double radius_m, const EffectCase& effect_case);

}  // namespace palpate
