#pragma once

// What a file says its surfaces feel like, as it says it. What becomes of it is the engine's part.

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace palpate {

// A glTF material and its extras.palpate.
struct MaterialDescription {
  std::string name;  // "material 3" when the file gives none
};

// An entry of physicsMaterials of KHR_physics_rigid_bodies.
struct PhysicsMaterialDescription {};

// An entry of materials of MPEG_haptic_material.
struct HapticMaterialDescription {
  std::string name;
};

}  // namespace palpate
