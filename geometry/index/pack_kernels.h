#pragma once

// The loops over the lanes of packs, once for every instruction set. Private to geometry: the
// questions as others ask them are in pack_queries.h.

#include <cstddef>
#include <cstdint>

#include "geometry/index/triangle_pack.h"

namespace palpate {

// Distances of a point to the triangles of one pack, local units.
struct alignas(64) LaneDistances {
  float squared[TrianglePack::kLanes];
  float error;  // bound on that of each distance

  // Whether the triangle may be as near as distance_local, for one rounded up.
  bool may_be_within(int lane, float distance_local) const {
    const float limit = distance_local + error;
    return !(squared[lane] > limit * limit * (1 + 0x1p-20f));
  }
};

// Plain arrays and no Eigen: these functions are compiled with other -m flags than the rest, and
// an inline function of a library, compiled so, could be the one that the linker keeps.
struct PackKernels {
  // See lanes_in_the_way(). Returns how many entries of out were written, at most count.
  std::size_t (*in_the_way)(const TrianglePack* packs, const std::uint32_t* ids, std::size_t count,
                            const double* p, const double* d, double clearance, PackLanes* out);
  // See lanes_in_reach().
  std::size_t (*in_reach)(const TrianglePack* packs, const std::uint32_t* ids, std::size_t count,
                          const double* p, const double* d, double reach, PackApproach* out);
  // See boxes_along().
  std::size_t (*boxes_along)(const BoxPack* packs, std::size_t pack_count, const double* p,
                             const double* d, double reach, const FloatBox& within,
                             std::uint32_t* out);
  // See boxes_within(). `squared_distances` is aligned as a pack is.
  std::uint32_t (*boxes_within)(const BoxPack& boxes, const float* p, float radius,
                                float* squared_distances);
  // See boxes_on_segment().
  std::uint32_t (*boxes_on_segment)(const BoxPack& boxes, const float* p, const float* d,
                                    float radius);
  // See lanes_within(). `distances` is aligned as a pack is.
  std::uint32_t (*within)(const TrianglePack& pack, const double* p, double distance,
                          LaneDistances& distances);
};

// Those of simd_level().
const PackKernels& pack_kernels() noexcept;

}  // namespace palpate
