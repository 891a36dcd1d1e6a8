#pragma once

// The point of a surface that is nearest to a point, with counted work.

#include <cstdint>
#include <optional>

#include "geometry/index/stretch.h"
#include "haptics/proxy/work.h"

namespace palpate {

// A point of a surface. Body frame and its unit (ContactBody).
struct NearestPoint {
  Vec3 point;
  double distance;
  std::uint32_t slot;  // of the triangle
};

struct NearestResult {
  std::optional<NearestPoint> nearest;
  bool is_cut_short = false;  // the work is spent: `nearest` is the nearest point found so far
};

// The nearest point within `range` of p_body. stretch: of the body, or null. known: a triangle of
// the surface that may be near, with which the search begins. If several triangles are equally
// near, the first one found is returned. The result does not depend on the instruction set. Safe on
// the haptic thread: no allocation, lock or exception.
NearestResult find_nearest(const SurfaceIndex& index, const Stretch* stretch, const Vec3& p_body,
                           double range, std::optional<std::uint32_t> known,
                           WorkMeter& work) noexcept;

}  // namespace palpate
