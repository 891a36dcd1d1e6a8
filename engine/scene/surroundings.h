#pragma once

// Declarations of a scene and its nodes that do not belong to surfaces: force fields that act
// everywhere, and regions with a medium.

#include <optional>
#include <span>
#include <string>

#include "engine/scene/material_effects.h"
#include "geometry/base/result.h"
#include "haptics/effects/gravity.h"
#include "haptics/effects/viscosity.h"
#include "io/scene_description.h"

namespace palpate {

// The keys of scenes and of nodes that belong to no effect. If the value of a key is a list, the
// limits of the key apply to each number in the list.
std::span<const ParameterKey> scene_keys();   // gravity, toolMass, constantForce
std::span<const ParameterKey> region_keys();  // size, radius
inline constexpr std::string_view kMediumKey = "medium";
inline constexpr std::array<std::string_view, 2> kMediumShapes = {"box", "sphere"};

// The force fields that act everywhere. gravity has no value if the scene declares no field.
struct SceneFields {
  std::optional<GravityEffect::Parameters> gravity;
  MaterialReport report;
};

// gravity and toolMass must be given together. Errors are like those of material_effects().
Result<SceneFields> scene_fields(const MaterialDescription& scene_parameters);

// The medium of a node. If the viscosity is 0, the region has no effect.
struct NodeMedium {
  MediumRegion region;
  double viscosity_Ns_per_m = 0.0;
  MaterialReport report;
};

// anchor_scene_m: origin of the solver frame. The node of a box may have any transform that is not
// singular; the node of a sphere must have the same scale along all axes. Errors are like those of
// material_effects().
Result<NodeMedium> node_medium(const RegionDescription& region, const Vec3& anchor_scene_m);

}  // namespace palpate
