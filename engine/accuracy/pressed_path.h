#pragma once

// Paths of a device that slides along a surface and is pressed into it. The surface is known in
// closed form.

#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/base/random.h"
#include "geometry/base/types.h"

namespace palpate {

// A point on a surface and the surface's normal there. Scene frame.
struct SmoothPoint {
  Vec3 point_m = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // unit, outward
};

// Maps a point near a smooth surface to a point on it. Scene frame, metres.
using SmoothSurface = std::function<SmoothPoint(const Vec3& near_m)>;

// These surfaces map to the nearest surface point. They are centred at the origin; the axis of the
// torus is z.
SmoothSurface smooth_sphere(double radius_m);
SmoothSurface smooth_torus(double major_radius_m, double minor_radius_m);
// The surface of bumpy_sphere() (models). It maps to the surface point in the same direction from
// the origin, which is not the nearest surface point.
SmoothSurface smooth_bumpy_sphere(double radius_m, double bump_height_m, int waves);

struct PressSettings {
  double speed_m_per_s = 0.1;
  // The depth oscillates between these two values with a period of 0.5 s.
  double least_depth_m = 1e-3;
  double most_depth_m = 3e-3;
  // In contact, the centre of a sphere proxy is this far outside the surface. Depths are measured
  // from there. 0: a point proxy.
  double proxy_radius_m = 0.0;
  double period_s = 1e-3;    // of a tick
  std::size_t ticks = 1000;  // number of ticks in contact
};

struct PressedPath {
  std::vector<Vec3> device_m;  // one position per tick, scene frame
  std::size_t lead_in = 0;     // number of ticks of the approach, before the ticks in contact
};

// A path that begins at a random point of the surface and slides in a random direction, with slight
// turns to both sides. The path approaches that point from outside, because the first sample of a
// loop determines on which side of the surface the proxy is. extent_m: the side of the cube about
// the origin from which the random point is drawn, before the surface maps it.
PressedPath pressed_path(const SmoothSurface& surface, double extent_m,
                         const PressSettings& settings, SeededRandom& random);

}  // namespace palpate
