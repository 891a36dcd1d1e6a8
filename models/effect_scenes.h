#pragma once

// One scene for each haptic effect, and a gallery of all effects. models/MODELS.md describes what
// each scene declares and how it feels.
//
// Frame: scene, metres; slabs lie in the x-y plane and z is up, as in the model of the thin plate.
// An effect scene covers at most 0.1 x 0.1 m around the origin, the gallery 0.34 x 0.38 m. Not for
// the haptic thread. Thread-safe.

#include <string>
#include <vector>

#include "models/scene_content.h"

namespace palpate {

struct EffectScene {
  std::string name;  // "effect_magnet"
  SceneContent content;
};

// One scene per effect, then the scene "gallery", which has the nodes of all other scenes and the
// gravity of effect_gravity. A node, its mesh and its material are named after the effect.
std::vector<EffectScene> effect_scenes();

}  // namespace palpate
