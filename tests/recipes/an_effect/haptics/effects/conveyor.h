#pragma once

// Conveyor: a surface that pushes what touches it.

#include "haptics/effects/effect.h"

namespace palpate {

// A constant force along the scene's x axis, without its part along the normal: F = f (x - (x.n)
// n).
struct ConveyorEffect {
  static constexpr std::string_view kName = "conveyor";
  static constexpr EffectStage kStage = EffectStage::kForceAdd;
  static constexpr std::uint32_t kNeeds = kNeedsContact;

  struct Parameters {
    double force_N = 0.0;
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"conveyorForce", "N", 0.0, 20.0, offsetof(Parameters, force_N),
       ParameterKey::Role::kDeclares, "force along the surface, towards the scene's x axis"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    const Vec3 along = Vec3::UnitX() - tick.normal.x() * tick.normal;
    tick.force_N += tick.share * p.force_N * along;
    return true;
  }
};

}  // namespace palpate
