#pragma once

// An exact collinearity test on double coordinates, and an accurate unit normal.
//
// Both functions use exact arithmetic on expansions, behind a filter that decides nearly every call
// (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997). They are valid for finite coordinates if no significant bit lies more than
// 1,000 binary places below the most significant one. The functions scale the corners first, so
// that products of huge coordinates do not overflow and products of tiny coordinates do not
// underflow.
//
// Any frame, any unit. No allocation; thread-safe. Requires rounding to nearest.

#include "geometry/base/types.h"

namespace palpate {

// True iff a, b and c lie on one line or coincide in exact arithmetic, so that the triangle has no
// area.
bool exactly_collinear(const Vec3& a, const Vec3& b, const Vec3& c);

// The unit normal of the triangle a, b, c, counter-clockwise from its front. Each component has a
// relative error of a few ulp (unless the component is below 1e-300), however thin the triangle is.
// Requires !exactly_collinear(a, b, c).
Vec3 accurate_unit_normal(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace palpate
