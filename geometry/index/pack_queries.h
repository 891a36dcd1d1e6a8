#pragma once

// Questions asked of all triangles of a pack at once. They only sort out: whatever may matter is
// decided afterwards, one triangle at a time, by the exact code (triangle.h, segment_triangle.h).
// None ever leaves out a triangle that it should name; each may name some that rounding brings
// near. All coordinates in the frame of the index, metres. No allocation, noexcept.

#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/base/types.h"
#include "geometry/index/pack_kernels.h"

namespace palpate {

// Triangles that the closed segment p to p + d, or any part of it, may come as near to as
// clearance_m. Writes the packs that have any; out must have room for all of ids.
inline std::size_t lanes_in_the_way(const TrianglePack* packs, std::span<const std::uint32_t> ids,
                                    const Vec3& p, const Vec3& d, double clearance_m,
                                    PackLanes* out) noexcept {
  return pack_kernels().in_the_way(packs, ids.data(), ids.size(), p.data(), d.data(), clearance_m,
                                   out);
}

// Triangles that the segment may come as near to as reach_m > 0. Sorts out the better the shorter
// the segment is next to the reach. Writes the packs that have any; out must have room for all of
// ids.
inline std::size_t lanes_in_reach(const TrianglePack* packs, std::span<const std::uint32_t> ids,
                                  const Vec3& p, const Vec3& d, double reach_m,
                                  PackApproach* out) noexcept {
  return pack_kernels().in_reach(packs, ids.data(), ids.size(), p.data(), d.data(), reach_m, out);
}

// Which of the boxes meet the box around the segment p to p + d, grown by reach_m, where that is
// within another. Writes their numbers in ascending order; out must have room for all lanes.
inline std::size_t boxes_along(std::span<const BoxPack> packs, const Vec3& p, const Vec3& d,
                               double reach_m, const FloatBox& within,
                               std::uint32_t* out) noexcept {
  return pack_kernels().boxes_along(packs.data(), packs.size(), p.data(), d.data(), reach_m, within,
                                    out);
}

// Squared distances of a point to sixteen boxes, m2.
struct alignas(64) BoxDistances {
  float squared[TrianglePack::kLanes];
};

// Boxes that come within radius of p: a bit each. The rounding of p is the caller's to allow for.
inline std::uint32_t boxes_within(const BoxPack& boxes, const float (&p)[3], float radius,
                                  BoxDistances& distances) noexcept {
  return pack_kernels().boxes_within(boxes, p, radius, distances.squared);
}

// Boxes that, grown by radius, meet the segment p to p + d: a bit each. The rounding of p and d is
// the caller's to allow for.
inline std::uint32_t boxes_on_segment(const BoxPack& boxes, const float (&p)[3],
                                      const float (&d)[3], float radius) noexcept {
  return pack_kernels().boxes_on_segment(boxes, p, d, radius);
}

// Triangles that may be as near to p as distance_m: a bit each.
inline std::uint32_t lanes_within(const TrianglePack& pack, const Vec3& p, double distance_m,
                                  LaneDistances& distances) noexcept {
  return pack_kernels().within(pack, p.data(), distance_m, distances);
}

// A length in the local units of a pack, rounded up.
inline float local_length(const TrianglePack& pack, double length_m) {
  return static_cast<float>(length_m * pack.per_metre) * (1 + 0x1p-20f);
}

// The lane of a set that is not empty with the least of `values`.
inline int least_lane(std::uint32_t lanes, const float (&values)[TrianglePack::kLanes]) {
  int least = __builtin_ctz(lanes);
  for (lanes &= lanes - 1; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    if (values[lane] < values[least]) least = lane;
  }
  return least;
}

// Takes the lowest lane out of a set that is not empty.
inline int take_lane(std::uint32_t& lanes) {
  const int lane = __builtin_ctz(lanes);
  lanes &= lanes - 1;
  return lane;
}

}  // namespace palpate
