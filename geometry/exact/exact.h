#pragma once

// Exact predicates on double coordinates, and the normal that goes with them.
//
// Both functions are exact arithmetic on expansions, behind a filter that settles nearly every call
// (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997). They hold for any finite coordinates of which no significant bit lies more
// than 1,000 binary places below the largest: corners are scaled first, so that neither products of
// huge coordinates overflow nor those of tiny ones underflow.
//
// Any frame, any unit. No allocation; safe on any thread. Rounding must be to nearest.

#include "geometry/base/types.h"

namespace palpate {

// True iff a, b and c lie on one line (or coincide) in exact arithmetic: the triangle has no area.
bool exactly_collinear(const Vec3& a, const Vec3& b, const Vec3& c);

// The unit normal of the triangle a, b, c, counter-clockwise from its front. However thin the
// triangle is, each component is within a few ulp of itself (unless below 1e-300).
// Requires !exactly_collinear(a, b, c).
Vec3 accurate_unit_normal(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace palpate
