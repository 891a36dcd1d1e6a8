#pragma once

// Where a device goes over a sphere at the origin, one sample a tick. Metres, in the sphere's
// frame. Deterministic.

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"

namespace palpate {

inline constexpr double kSpherePathSpeed_m_per_s = 0.1;
inline constexpr double kSpherePathPeriod_s = 1e-3;
inline constexpr double kSpherePathStep_m = kSpherePathSpeed_m_per_s * kSpherePathPeriod_s;

// The bounds of the height above the sphere (below it: negative) and the time of one swing between
// them and back. Requires a climb slower than the path: pi (high - low) / period.
struct HeightSwing {
  double low_m;
  double high_m;
  double period_s;
};

// Where the path begins: away from the icosphere's planes of symmetry, where edges would be met end
// on. Unit.
Vec3 sphere_path_start();

// Moves kSpherePathSpeed_m_per_s along a gently weaving line over the sphere, so that it keeps
// meeting new triangles, while its height swings; starts at the upper bound. Consecutive samples
// are kSpherePathStep_m apart, within the curvature of a step.
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

}  // namespace palpate
