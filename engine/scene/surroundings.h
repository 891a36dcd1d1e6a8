#pragma once

// What a scene and its nodes declare besides surfaces: fields that act everywhere, and regions with
// a medium.

#include <optional>
#include <span>
#include <string>

#include "engine/scene/material_effects.h"
#include "geometry/base/result.h"
#include "haptics/effects/gravity.h"
#include "haptics/effects/viscosity.h"
#include "io/scene_description.h"

namespace palpate {

// The keys that scenes and nodes have and no effect: of lists, of each number in them.
std::span<const ParameterKey> scene_keys();   // gravity, toolMass, constantForce
std::span<const ParameterKey> region_keys();  // size, radius
inline constexpr std::string_view kMediumKey = "medium";
inline constexpr std::array<std::string_view, 2> kMediumShapes = {"box", "sphere"};

// What acts everywhere; no value if nothing does.
struct SceneFields {
  std::optional<GravityEffect::Parameters> gravity;
  MaterialReport report;
};

// Gravity needs the mass of the tool, and the other way round. Errors as of material_effects().
Result<SceneFields> scene_fields(const MaterialDescription& scene_parameters);

// The medium of a node. Without a viscosity there is none, and the region is not felt.
struct NodeMedium {
  MediumRegion region;
  double viscosity_Ns_per_m = 0.0;
  MaterialReport report;
};

// anchor_scene_m: origin of the solver frame. A box can have any place, scale and shear that is not
// singular; a sphere only the same scale along all axes. Errors as of material_effects().
Result<NodeMedium> node_medium(const RegionDescription& region, const Vec3& anchor_scene_m);

}  // namespace palpate
