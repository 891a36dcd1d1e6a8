#pragma once

// The tolerances for rounding in judgements of a proxy.

#include "tests/helpers/floating_point.h"

namespace palpate::test {

// The distance, in ulps, by which a sphere may come nearer to a triangle than its radius, because
// positions and distances are rounded.
inline constexpr double kNearUlps = 64;

// The tolerance for steps that must not increase the distance to the goal: the increase that is
// still accepted. It allows for the rounding of the projection (relative) and of the coordinates of
// the step's corner (in ulps).
inline constexpr double kFartherRelative = 32 * kEpsilon;
inline constexpr double kFartherUlps = 4;

// Smallest depth that counts as an overlap for a user, relative to the scene's size.
inline constexpr double kOverlapPerSize = 1e-9;

}  // namespace palpate::test
