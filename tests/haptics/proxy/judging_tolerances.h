#pragma once

// The tolerances for rounding in judgements of a proxy.

#include "tests/helpers/floating_point.h"

namespace palpate::test {

// A sphere may come nearer than its radius by the rounding of positions and distances, in ulps.
inline constexpr double kNearUlps = 64;

// A step that must not increase the distance to the goal may increase it by the rounding of the
// projection (relative) and of the coordinates of its corner (ulps).
inline constexpr double kFartherRelative = 32 * kEpsilon;
inline constexpr double kFartherUlps = 4;

// Smallest depth that counts as an overlap for a user, relative to the scene's size.
inline constexpr double kOverlapPerSize = 1e-9;

}  // namespace palpate::test
