#pragma once

// Gravity: constant forces everywhere in a scene.

#include "haptics/effects/effect.h"

namespace palpate {

// The weight of the tool and a constant field: F = m g + F0, in scene axes, so that the force turns
// with the scene.
struct GravityEffect {
  static constexpr std::string_view kName = "gravity";
  static constexpr EffectStage kStage = EffectStage::kSurroundings;
  static constexpr std::uint32_t kNeeds = kNeedsSurroundings;

  struct Parameters {
    double mass_kg = 0.0;
    double gravity_m_per_s2[3] = {};
    double field_N[3] = {};
  };
  struct State {};
  // There are no keys, because the scene sets these parameters, not a material (see the engine's
  // scene_effects.h).
  static constexpr std::span<const ParameterKey> kKeys = {};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    for (int i = 0; i < 3; ++i) tick.force_N[i] += p.mass_kg * p.gravity_m_per_s2[i] + p.field_N[i];
    return true;
  }
};

}  // namespace palpate
