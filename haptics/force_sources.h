#pragma once

// What the force of a tick comes from, as far as the safety governor must know it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "haptics/effects/giving_forces.h"

namespace palpate {

// What may give energy to the hand by design. Each has a budget (EnergyBudgets).
enum class EnergySource : std::uint8_t {
  kMotors,     // missing motors, and A4, which turns the scene
  kNodes,      // moving nodes
  kVibration,  // the effect of this name, and so on
  kRestitution,
  kMagnet,
  kGravity,
  kOther,  // the surface: friction, texture, shading; and all other effects
};
inline constexpr std::size_t kEnergySourceCount = 7;
// The places of kGivingEffects.
inline constexpr std::size_t kFirstGivingEffect = 2;
inline constexpr std::array<std::string_view, kEnergySourceCount> kEnergySourceNames = {
    "motors", "nodes", "vibration", "restitution", "magnet", "gravity", "other"};

struct ForceSources {
  // The spring of the contact: its stiffness, and the length of the lag from the device point to
  // the proxy; with a strategy whose spring is not isotropic, those of its CountedSpring. 0, 0: no
  // contact, or unknown.
  double stiffness_N_per_m = 0.0;
  double lag_m = 0.0;
  // What nodes that moved in this tick have added to the energy of the spring.
  bool nodes_moved = false;
  double nodes_J = 0.0;
  // The forces of effects with a budget of their own, device frame; zero unless has_effects.
  bool has_effects = false;
  GivingForces effects_N = no_giving_forces();
};

}  // namespace palpate
