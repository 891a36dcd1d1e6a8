#pragma once

// Where a device goes in the benchmarks: paths along a sphere about the origin, one sample a tick.
//
// Every path moves kSpeed_m_per_s along a gently weaving line over the sphere, so that it keeps
// meeting new triangles, while its height above the sphere swings between two bounds. Metres, in
// the sphere's frame. Deterministic: no random numbers, no clock.

#include <cstddef>
#include <vector>

#include "geometry/types.h"

namespace palpate::bench {

inline constexpr double kSampleRateHz = 1000.0;
inline constexpr double kSpeed_m_per_s = 0.1;

// The bounds of the height above the sphere (below it: negative) and the time of one swing between
// them and back. Requires a climb slower than kSpeed_m_per_s: pi (high - low) / period.
struct HeightSwing {
  double low_m;
  double high_m;
  double period_s;
};

inline constexpr HeightSwing kFree{1e-3, 5e-3, 0.5};       // never touches
inline constexpr HeightSwing kSliding{-5e-3, -1e-4, 0.5};  // always pressed in
inline constexpr HeightSwing kTapping{-3e-3, 3e-3, 0.25};  // in and out, four times a second
inline constexpr HeightSwing kNear{0.0, 5e-3, 0.5};        // as a device point on its way out
inline constexpr HeightSwing kOnSurface{0.0, 0.0, 0.5};    // as a proxy in contact

// Starts at the upper bound. Consecutive samples are kSpeed_m_per_s / kSampleRateHz apart, within
// the curvature of a step.
std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count);

}  // namespace palpate::bench
