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

// The bounds of the height above the sphere (negative: below) and the period of the swing between
// them. Requires a climb slower than the path: pi (high - low) / period.
struct HeightSwing {
  double low_m;
  double high_m;
  double period_s;
};

// The start of the path: away from the planes of symmetry of the icosphere, where the path would
// run along edges. Unit.
Vec3 sphere_path_start();

// Moves at kSpherePathSpeed_m_per_s along a gently weaving line over the sphere, so that it keeps
// reaching new triangles, while its height swings; starts at the upper bound. Consecutive samples
// are kSpherePathStep_m apart, within the curvature of a step.
std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count);

// A path, and the approach to its start.
struct DevicePath {
  std::vector<Vec3> lead_in_m;  // not timed
  std::vector<Vec3> timed_m;
};

// path_over_sphere() with an approach from outside, because the first sample of a loop determines
// the side of the proxy.
DevicePath entered_path_over_sphere(double radius_m, const HeightSwing& swing,
                                    std::size_t sample_count);

}  // namespace palpate
