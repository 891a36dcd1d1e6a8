#pragma once

// Device paths of the benchmarks: paths about a sphere at the origin, one sample per tick. Metres,
// in the sphere's frame. Deterministic: random paths have fixed seeds.

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
inline constexpr HeightSwing kNear{0.0, 5e-3, 0.5};  // like a device point that leaves the surface
inline constexpr HeightSwing kOnSurface{0.0, 0.0, 0.5};  // like a proxy in contact

// A path from kStep_m outside the sphere straight towards its centre, without the centre itself.
std::vector<Vec3> path_to_centre(double radius_m);

// A path that begins at the exact centre of the sphere, where all triangles are about equally near.
// Its further points lie around the centre in all directions, at distances from a nanometre to
// farthest_m.
std::vector<Vec3> path_about_centre(double farthest_m, std::size_t sample_count);

// A path with a jump in every tick, at most longest_m long, between points uniformly distributed
// over the ball.
std::vector<Vec3> random_teleports(double ball_radius_m, double longest_m,
                                   std::size_t sample_count);

}  // namespace palpate::bench
