#pragma once

// Scenes of a sphere with effects, and of the same sphere without effects. The cost of an effect is
// the difference between the costs of these two scenes.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"

namespace palpate {

// The names of all effects as in reports, in the order of PALPATE_EFFECTS.
std::span<const std::string_view> measured_effects();

struct EffectCase {
  std::string name;
  std::vector<std::string_view> effects;  // from measured_effects(), in the same order
  // If true, the effects belong to a second, small sphere, which is never touched.
  bool is_elsewhere = false;

  bool has(std::string_view effect) const;
};

EffectCase only(std::string_view effect);     // has the name of the effect
EffectCase all_but(std::string_view effect);  // "all but friction"
EffectCase all_effects();                     // "all"
EffectCase effects_elsewhere();               // "elsewhere"
// The geometry of a case without its effects.
EffectCase without_effects(const EffectCase& effect_case);

// A scene of an icosphere about the origin, like the scene of a file with the same declarations.
// The icosphere has 20 * 4^subdivisions triangles. The effects of the case are declared for the
// surface of the icosphere, for a medium and for a force field, or for the second sphere
// (is_elsewhere). Metres. Returns the error of Scene::compile() if the program was built without
// one of the effects.
Result<Scene> effect_scene(int subdivisions, double radius_m, const EffectCase& effect_case);

}  // namespace palpate
