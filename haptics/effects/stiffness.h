#pragma once

// Stiffness: the spring of the virtual coupling, by material.

#include "haptics/effects/effect.h"

namespace palpate {

// The spring F = K (p - g) between proxy p and goal g (Colgate, Stanley and Brown 1995, "Issues in
// the haptic display of tool use"; Lecuyer et al. 2005, section 3). Materials without this effect
// use the loop's K. If several materials are touched, each contributes by its share of the contact
// force.
struct StiffnessEffect {
  static constexpr std::string_view kName = "stiffness";
  static constexpr EffectStage kStage = EffectStage::kForceMap;
  static constexpr std::uint32_t kNeeds = kNeedsContact;

  struct Parameters {
    double stiffness_N_per_m = 0.0;
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"stiffness", "N/m", 0.0, 1e6, offsetof(Parameters, stiffness_N_per_m),
       ParameterKey::Role::kRequired, "spring between proxy and device point"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    tick.coupling.stiffness_N_per_m = p.stiffness_N_per_m;
    return true;
  }
};

}  // namespace palpate
