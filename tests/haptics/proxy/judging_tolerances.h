#pragma once

// What rounding may do to a proxy before a judge calls it wrong.

#include "tests/helpers/floating_point.h"

namespace palpate::test {

// A sphere may come nearer by the rounding of positions and distances.
inline constexpr double kNearUlps = 64;

// What a step that should keep the distance may add to it: the rounding of the projection
// (relative), and of the corner's coordinates.
inline constexpr double kFartherRelative = 32 * kEpsilon;
inline constexpr double kFartherUlps = 4;

// Of the scene's size; what a user could call an overlap.
inline constexpr double kOverlapPerSize = 1e-9;

}  // namespace palpate::test
