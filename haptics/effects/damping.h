#pragma once

// Damping: the damper of the virtual coupling, by material.

#include "haptics/effects/effect.h"

namespace palpate {

// The damper in parallel with the spring (Colgate, Stanley and Brown 1995; Lecuyer et al. 2005,
// section 3); VirtualCoupling explains which velocity it acts on. Materials without this effect use
// the loop's B.
struct DampingEffect {
  static constexpr std::string_view kName = "damping";
  static constexpr EffectStage kStage = EffectStage::kForceMap;
  static constexpr std::uint32_t kNeeds = kNeedsContact;

  struct Parameters {
    double damping_Ns_per_m = 0.0;
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"damping", "N s/m", 0.0, 1e4, offsetof(Parameters, damping_Ns_per_m),
       ParameterKey::Role::kRequired, "damper in parallel with the spring"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    tick.coupling.damping_Ns_per_m = p.damping_Ns_per_m;
    return true;
  }
};

}  // namespace palpate
