#pragma once

// Filters that test all triangles or boxes of a pack in parallel. The filters are conservative:
// they never drop an element in range and may keep an element that is out of range by a rounding
// error. Code in double (triangle.h, segment_triangle.h) then decides for the remaining triangles,
// one at a time. All coordinates are in the index frame, metres. No allocation, noexcept.

#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/base/types.h"
#include "geometry/index/pack_kernels.h"

namespace palpate {

// Finds the triangles that may be within clearance_m of the closed segment p to p + d. Writes the
// packs with at least one such triangle and returns their number. `out` must have ids.size()
// entries.
inline std::size_t lanes_in_the_way(const TrianglePack* packs, std::span<const std::uint32_t> ids,
                                    const Vec3& p, const Vec3& d, double clearance_m,
                                    PackLanes* out) noexcept {
  return pack_kernels().in_the_way(packs, ids.data(), ids.size(), p.data(), d.data(), clearance_m,
                                   out);
}

// Finds the triangles that may be within reach_m > 0 of the segment p to p + d. The filter is more
// selective for segments that are short compared with reach_m. Writes the packs with at least one
// such triangle and returns their number. `out` must have ids.size() entries.
inline std::size_t lanes_in_reach(const TrianglePack* packs, std::span<const std::uint32_t> ids,
                                  const Vec3& p, const Vec3& d, double reach_m,
                                  PackApproach* out) noexcept {
  return pack_kernels().in_reach(packs, ids.data(), ids.size(), p.data(), d.data(), reach_m, out);
}

// Finds the boxes that meet the query box: the bounding box of the segment p to p + d, grown by
// reach_m and intersected with `within`. Writes their numbers in ascending order and returns the
// count. `out` must have one entry per lane.
inline std::size_t boxes_along(std::span<const BoxPack> packs, const Vec3& p, const Vec3& d,
                               double reach_m, const FloatBox& within,
                               std::uint32_t* out) noexcept {
  return pack_kernels().boxes_along(packs.data(), packs.size(), p.data(), d.data(), reach_m, within,
                                    out);
}

// Squared distances from a point to sixteen boxes, m2.
struct alignas(64) BoxDistances {
  float squared[TrianglePack::kLanes];
};

// Finds the boxes within `radius` of p; returns one bit per box. The caller must include the
// rounding of p in `radius`.
inline std::uint32_t boxes_within(const BoxPack& boxes, const float (&p)[3], float radius,
                                  BoxDistances& distances) noexcept {
  return pack_kernels().boxes_within(boxes, p, radius, distances.squared);
}

// Finds the boxes that, grown by `radius`, meet the segment p to p + d; returns one bit per box.
// The caller must allow for the rounding of p and d.
inline std::uint32_t boxes_on_segment(const BoxPack& boxes, const float (&p)[3],
                                      const float (&d)[3], float radius) noexcept {
  return pack_kernels().boxes_on_segment(boxes, p, d, radius);
}

// Finds the triangles that may be within distance_m of p; returns one bit per lane.
inline std::uint32_t lanes_within(const TrianglePack& pack, const Vec3& p, double distance_m,
                                  LaneDistances& distances) noexcept {
  return pack_kernels().within(pack, p.data(), distance_m, distances);
}

// A length in the local units of a pack, rounded up.
inline float local_length(const TrianglePack& pack, double length_m) {
  return static_cast<float>(length_m * pack.per_metre) * (1 + 0x1p-20f);
}

// Returns the lane with the smallest value. Requires at least one lane in the set.
inline int least_lane(std::uint32_t lanes, const float (&values)[TrianglePack::kLanes]) {
  int least = __builtin_ctz(lanes);
  for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    if (values[lane] < values[least]) least = lane;
  }
  return least;
}

// Removes the lowest lane from the set and returns it. Requires at least one lane in the set.
inline int take_lane(std::uint32_t& lanes) {
  const int lane = __builtin_ctz(lanes);
  lanes &= lanes - 1;
  return lane;
}

}  // namespace palpate
