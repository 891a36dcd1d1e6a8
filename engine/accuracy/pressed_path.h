#pragma once

// Paths of a device that slides pressed into a surface known in closed form.

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

// The point of a smooth surface that belongs to a point near it. Scene frame, metres.
using SmoothSurface = std::function<SmoothPoint(const Vec3& near_m)>;

// The nearest one. Centre at the origin; the torus lies about z.
SmoothSurface smooth_sphere(double radius_m);
SmoothSurface smooth_torus(double major_radius_m, double minor_radius_m);
// The one in the same direction, of models' bumpy_sphere().
SmoothSurface smooth_bumpy_sphere(double radius_m, double bump_height_m, int waves);

struct PressSettings {
  double speed_m_per_s = 0.1;
  double least_depth_m = 1e-3;  // the depth swings between the two, half a second a swing
  double most_depth_m = 3e-3;
  double proxy_radius_m = 0.0;  // a sphere's centre touches that far outside
  double period_s = 1e-3;
  std::size_t ticks = 1000;  // in contact
};

struct PressedPath {
  std::vector<Vec3> device_m;
  std::size_t lead_in = 0;  // ticks from outside to the first in contact
};

// From a random point, in a random direction that wavers. Starts outside, as the first sample of a
// loop says on which side the proxy is. extent_m: of the surface, for the random point.
PressedPath pressed_path(const SmoothSurface& surface, double extent_m,
                         const PressSettings& settings, SeededRandom& random);

}  // namespace palpate
