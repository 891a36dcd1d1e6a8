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

// What a search that was cut short leaves for the next one, which may be for another point. Plain
// numbers, because it is a part of an effect's state.
struct NearestCursor {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t slot = kNone;    // of the triangle found, or none
  std::uint32_t next_pack = 0;   // the packs continue here
  std::uint32_t packs_left = 0;  // to be searched until the result is the nearest point
};

// The nearest point within `range` of p_body. stretch: of the body, or null. A search visits near
// packs first. After a search that was cut short, packs are visited in the order of their numbers,
// round and round, beginning where the last search ended; the triangle found before is considered
// first. If the point stays the same (has_moved is false), the search ends after one round. At
// least one pack is visited. If several triangles are equally near, the first one found is
// returned. The result does not depend on the instruction set. Safe on the haptic thread: no
// allocation, lock or exception.
NearestResult find_nearest(const SurfaceIndex& index, const Stretch* stretch, const Vec3& p_body,
                           double range, bool has_moved, NearestCursor& cursor,
                           WorkMeter& work) noexcept;

}  // namespace palpate
