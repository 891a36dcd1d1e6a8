#pragma once

// Where a device goes in the benchmarks: paths about a sphere at the origin, one sample a tick.
// Metres, in the sphere's frame. Deterministic: what is random has a fixed seed.

#include <cstddef>
#include <vector>

#include "engine/accuracy/sphere_paths.h"
#include "geometry/base/types.h"

namespace palpate::bench {

inline constexpr double kDt_s = kSpherePathPeriod_s;
inline constexpr double kStep_m = kSpherePathStep_m;  // from sample to sample

inline constexpr HeightSwing kFree{1e-3, 5e-3, 0.5};       // never touches
inline constexpr HeightSwing kSliding{-5e-3, -1e-4, 0.5};  // always pressed in
inline constexpr HeightSwing kTapping{-3e-3, 3e-3, 0.25};  // in and out, four times a second
inline constexpr HeightSwing kNear{0.0, 5e-3, 0.5};        // as a device point on its way out
inline constexpr HeightSwing kOnSurface{0.0, 0.0, 0.5};    // as a proxy in contact

// From kStep_m outside the sphere straight towards its centre, which is not in it.
std::vector<Vec3> path_to_centre(double radius_m);

// The exact centre of the sphere, from where every triangle is about as near, then points about it
// in all directions and at all distances from a nanometre to the farthest.
std::vector<Vec3> path_about_centre(double farthest_m, std::size_t sample_count);

// Jumps each tick, none longer than longest_m, between points evenly distributed over the ball.
std::vector<Vec3> random_teleports(double ball_radius_m, double longest_m,
                                   std::size_t sample_count);

}  // namespace palpate::bench
