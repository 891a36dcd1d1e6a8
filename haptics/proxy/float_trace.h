#pragma once

// trace_point() in single precision, for Accuracy::narrow_phase = kFloat.

#include "geometry/index/triangle_pack.h"
#include "haptics/proxy/triangle_trace.h"

namespace palpate {

// Does the same as trace_point() for the triangle in one lane of a pack, in single precision and in
// the local coordinates of the pack. p and q are in the frame of the index; stand_off_m is the
// distance at which the step is stopped, at least float_stand_off_m() of the pack.
//
// The function uses no exact signs and does not test the end of a step that misses the triangle. A
// proxy that rests beside an edge, within rounding of a plane, may therefore change to the other
// side of the plane. The function does not suit callers that need the certificate of a free step.
// Safe on the haptic thread; thread-safe.
bool trace_point_in_float(const TrianglePack& pack, int lane, const Vec3& p, const Vec3& q,
                          double stand_off_m, TriangleHit& hit) noexcept;

// The smallest stand-off for trace_point_in_float(): four times the rounding error of a height over
// a triangle. pack_reach_m: the largest coordinate of the pack relative to its centre; the proxy
// may be up to twice as far away. Like the bounds in pack_kernels.inl, this bound allows for 16
// roundings. Each rounding is at most 2^-24 times the sum of the magnitudes of the proxy's position
// (3 * 2) and the triangle (2), in units of pack_reach_m.
constexpr double float_stand_off_m(double pack_reach_m) {
  return 4 * 16 * 0x1p-24 * (3 * 2 + 2) * pack_reach_m;
}

}  // namespace palpate
