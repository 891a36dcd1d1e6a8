#pragma once

// Paths of a device that slides, pressed into a surface known in closed form.

#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/base/random.h"
#include "geometry/base/types.h"

namespace palpate {

struct SmoothPoint {
  Vec3 point_m = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // unit, outward
};

// Maps a point near a smooth surface to a point on it. Scene frame, metres.
using SmoothSurface = std::function<SmoothPoint(const Vec3& near_m)>;

// To the nearest point. The centre is the origin; the axis of the torus is z.
SmoothSurface smooth_sphere(double radius_m);
SmoothSurface smooth_torus(double major_radius_m, double minor_radius_m);
// To the point in the same direction, for bumpy_sphere() of models.
SmoothSurface smooth_bumpy_sphere(double radius_m, double bump_height_m, int waves);

struct PressSettings {
  double speed_m_per_s = 0.1;
  double least_depth_m =
      1e-3;  // the depth oscillates between the two, with a period of half a second
  double most_depth_m = 3e-3;
  double proxy_radius_m = 0.0;  // the centre of a sphere touches at this distance outside
  double period_s = 1e-3;
  std::size_t ticks = 1000;  // in contact
};

struct PressedPath {
  std::vector<Vec3> device_m;
  std::size_t lead_in = 0;  // ticks outside, before the first tick in contact
};

// From a random point, in a random, wavering direction. Starts outside, because the first sample of
// a loop determines the side of the proxy. extent_m: of the surface, for the random point.
PressedPath pressed_path(const SmoothSurface& surface, double extent_m,
                         const PressSettings& settings, SeededRandom& random);

}  // namespace palpate
