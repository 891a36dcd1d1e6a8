#pragma once

// Where a device goes in the benchmarks: paths about a sphere at the origin, one sample a tick.
// Metres, in the sphere's frame. Deterministic: what is random has a fixed seed.

#include <cstddef>
#include <vector>

#include "geometry/types.h"

namespace palpate::bench {

inline constexpr double kSampleRateHz = 1000.0;
inline constexpr double kSpeed_m_per_s = 0.1;
inline constexpr double kDt_s = 1.0 / kSampleRateHz;
inline constexpr double kStep_m = kSpeed_m_per_s * kDt_s;  // from sample to sample

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

// Moves kSpeed_m_per_s along a gently weaving line over the sphere, so that it keeps meeting new
// triangles, while its height swings; starts at the upper bound. Consecutive samples are kStep_m
// apart, within the curvature of a step.
std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count);

// A path, and how the device gets to its beginning.
struct DevicePath {
  std::vector<Vec3> lead_in_m;  // not timed
  std::vector<Vec3> timed_m;
};

// path_over_sphere(), come to from outside: the first sample of a loop says on which side the proxy
// is.
DevicePath entered_path_over_sphere(double radius_m, const HeightSwing& swing,
                                    std::size_t sample_count);

// From kStep_m outside the sphere straight towards its centre, which is not in it.
std::vector<Vec3> path_to_centre(double radius_m);

// The exact centre of the sphere, from where every triangle is about as near, then points about it
// in all directions and at all distances from a nanometre to the farthest.
std::vector<Vec3> path_about_centre(double farthest_m, std::size_t sample_count);

// Jumps each tick, none longer than longest_m, between points evenly distributed over the ball.
std::vector<Vec3> random_teleports(double ball_radius_m, double longest_m,
                                   std::size_t sample_count);

}  // namespace palpate::bench
