#pragma once

// The forces of the effects that may give energy to the hand of themselves.

#include <array>
#include <cstddef>
#include <string_view>

#include "geometry/base/types.h"

namespace palpate {

inline constexpr std::array<std::string_view, 4> kGivingEffects = {"vibration", "restitution",
                                                                   "magnet", "gravity"};

// By kGivingEffects, N.
using GivingForces = std::array<Vec3, kGivingEffects.size()>;

inline GivingForces no_giving_forces() {
  GivingForces forces;
  forces.fill(Vec3::Zero());
  return forces;
}

}  // namespace palpate
