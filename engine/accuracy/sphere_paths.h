#pragma once

// Paths of a device over a sphere at the origin, one sample per tick. Metres, in the frame of the
// sphere. Deterministic.

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

inline constexpr double kSpherePathSpeed_m_per_s = 0.1;
inline constexpr double kSpherePathPeriod_s = 1e-3;
inline constexpr double kSpherePathStep_m = kSpherePathSpeed_m_per_s * kSpherePathPeriod_s;

// The bounds of the height above the sphere (negative: below it), and the period with which the
// height swings between them. The fastest climb, pi (high_m - low_m) / period_s, must be slower
// than kSpherePathSpeed_m_per_s.
struct HeightSwing {
  double low_m;
  double high_m;
  double period_s;
};

// The direction from the centre of the sphere to the start of a path, as a unit vector. The start
// does not lie in a plane of symmetry of the icosphere, because a path in such a plane would run
// along edges.
Vec3 sphere_path_start();

// A path that moves at kSpherePathSpeed_m_per_s along a gently weaving line over the sphere, so
// that it always reaches new triangles. Its height swings and starts at the upper bound. The
// distance between consecutive samples is kSpherePathStep_m, apart from the effect of the path's
// curvature within a step.
std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count);

// A path, and the approach to its start.
struct DevicePath {
  std::vector<Vec3> lead_in_m;  // not timed
  std::vector<Vec3> timed_m;
};

// path_over_sphere() with an approach from outside, because the first sample of a loop determines
// on which side of the surface the proxy is.
DevicePath entered_path_over_sphere(double radius_m, const HeightSwing& swing,
                                    std::size_t sample_count);

}  // namespace palpate
