#pragma once

// The loops over the lanes of packs, compiled for each instruction set. Private to geometry:
// pack_queries.h has the public interface.

#include <cstddef>
#include <cstdint>

#include "geometry/index/triangle_pack.h"

namespace palpate {

// Distances of a point to the triangles of one pack, local units.
struct alignas(64) LaneDistances {
  float squared[TrianglePack::kLanes];
  float error;  // bound on the error of each distance

  // Whether the triangle may be within distance_local, which must be rounded up.
  bool may_be_within(int lane, float distance_local) const {
    const float limit = distance_local + error;
    return !(squared[lane] > limit * limit * (1 + 0x1p-20f));
  }
};

// The kernels use plain arrays and no Eigen types. They are compiled with different -m flags. If
// they used an inline function of a library, the linker could keep the copy that was compiled with
// these flags, and the whole program would use this copy.
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
  // See boxes_within(). `squared_distances` has the alignment of a pack.
  std::uint32_t (*boxes_within)(const BoxPack& boxes, const float* p, float radius,
                                float* squared_distances);
  // See boxes_on_segment().
  std::uint32_t (*boxes_on_segment)(const BoxPack& boxes, const float* p, const float* d,
                                    float radius);
  // See lanes_within(). `distances` has the alignment of a pack.
  std::uint32_t (*within)(const TrianglePack& pack, const double* p, double distance,
                          LaneDistances& distances);
};

// The kernels for simd_level().
const PackKernels& pack_kernels() noexcept;

}  // namespace palpate
