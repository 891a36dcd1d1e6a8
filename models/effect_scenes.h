#pragma once

// One scene for each haptic effect, and a gallery of all of them. models/README.md says what each
// declares and what a hand feels there.
//
// Frame: scene; slabs lie in x and y, z is up, as the thin plate has it; metres. An effect takes at
// most 0.1 x 0.1 m about the origin, the gallery 0.34 x 0.38 m. Not for the haptic thread.
// Thread-safe.

#include <string>
#include <vector>

#include "models/scene_content.h"

namespace palpate {

struct EffectScene {
  std::string name;  // "effect_magnet"
  SceneContent content;
};

// The gallery, "gallery", comes last: the nodes of all others, with the gravity of effect_gravity.
// A node is named after its effect, and so are its mesh and its material.
std::vector<EffectScene> effect_scenes();

}  // namespace palpate
