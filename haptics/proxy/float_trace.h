#pragma once

// trace_point() in single precision, for Accuracy::narrow_phase = kFloat.

#include "geometry/index/triangle_pack.h"
#include "haptics/proxy/triangle_trace.h"

namespace palpate {

// As trace_point() for one lane of a pack, with its local coordinates in single precision and
// without exact signs or a look at the end of the step: a proxy that comes to rest beside an edge,
// within rounding of a plane, may lose its side of it there. Not for those who need the
// certificate. The stand-off must be at least float_stand_off_m() of the pack.
bool trace_point_in_float(const TrianglePack& pack, int lane, const Vec3& p, const Vec3& q,
                          double stand_off_m, TriangleHit& hit) noexcept;

// Four times the rounding of a height over a triangle of a pack whose coordinates reach
// `pack_reach_m` from its centre, for a proxy that is no farther from there than twice that: 16
// roundings of 2^-24 for each component of the two, as in the bounds of pack_kernels.inl.
constexpr double float_stand_off_m(double pack_reach_m) {
  return 4 * 16 * 0x1p-24 * (3 * 2 + 2) * pack_reach_m;
}

}  // namespace palpate
