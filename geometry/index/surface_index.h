#pragma once

// Spatial queries on a surface: Embree finds clusters of triangles, and tests in double precision
// determine the results.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/fixed_array.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/exact/fraction.h"
#include "geometry/exact/triangle.h"
#include "geometry/index/ordered_boxes.h"
#include "geometry/index/triangle_pack.h"
#include "geometry/mesh/mapped_faces.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

class EmbreeBoxes;

// A point of the surface.
struct SurfacePoint {
  Vec3 point_m;
  double distance_m;
  std::uint32_t face;  // number of the face in the SurfaceMesh
};

// The first point where a segment meets the surface.
struct SegmentHit {
  double fraction;  // of the segment, in [0, 1]
  Vec3 point_m;
  std::uint32_t face;
};

// Bounds of a stretched ball: a ball, and a box given by its half extents.
struct StretchedBall {
  double radius_m;
  Vec3 by_axis_m;
};

// The triangles of a surface in the order of their packs: slot n is lane n % kLanes of pack n /
// kLanes. Slots past a pack's count repeat its last triangle. Packs n kLanes to (n + 1) kLanes - 1
// are close to each other and form cluster n.
struct PackedSurface {
  FixedArray<TrianglePack> packs;
  FixedArray<Box> boxes;                   // of the packs; an index frees these boxes
  FixedArray<TriangleGeometry> triangles;  // one per slot, in double: used for decisions
  FixedArray<std::uint32_t> faces;         // one per slot: face of the mesh
};

// A segment visitor returns kNothingMore to end the search completely. In that case, no further
// pack is visited, not even at the start of the segment.
inline constexpr QueryFraction kNothingMore{-1.0};

// Receives up to sixteen packs near a segment. Returns the fraction of the segment up to which the
// search should continue (QueryFraction::end() to visit all packs), or kNothingMore. Must not
// throw.
using PackVisitor = QueryFraction (*)(void* state, std::span<const std::uint32_t> packs);

// Receives up to sixteen packs and returns the same as a PackVisitor. in_order: the packs are in
// ascending order, and all packs before them have been visited. Must not throw.
using OrderedPackVisitor = QueryFraction (*)(void* state, std::span<const std::uint32_t> packs,
                                             bool in_order);
// Receives a pack. Returns the bounds around the query point within which the search should
// continue. Must not throw.
using NearestPackVisitor = StretchedBall (*)(void* state, std::uint32_t pack);
// Receives a pack, or no value before each test of sixteen boxes. Returns the radius within which
// the search should continue; a negative one ends it. Must not throw.
using NearestVisitor = double (*)(void* state, std::optional<std::uint32_t> pack);
// Receives up to sixteen packs in ascending order. Returns whether the search should continue. Must
// not throw.
using NearPackVisitor = bool (*)(void* state, std::span<const std::uint32_t> packs);

// An immutable index over one surface in its own frame, the index frame. The origin of the index
// frame should be near the middle of the surface, so that large coordinates do not cost precision.
// The unit of the index frame counts as the metre in the names below; ContactBody has the factor.
//
// Embree's BVH finds clusters of sixteen packs of sixteen triangles. Within a cluster, boxes and
// then triangles are filtered sixteen at a time. These filters use single precision and only narrow
// the search: boxes are enlarged by the rounding errors (kFloatMarginUlps), and every result is
// computed from vertices in double.
//
// Queries: no allocation, lock or exception; thread-safe; safe on the haptic thread. Query points
// must be finite.
class SurfaceIndex {
 public:
  // sweep_radius_m: the largest radius allowed in visit_segment() and visit_packs_along(). The
  // construction uses all cores; the result does not depend on their number.
  explicit SurfaceIndex(const MappedFaces& faces, double sweep_radius_m = 0.0);
  explicit SurfaceIndex(const SurfaceMesh& mesh, const AffineMap& map = {},
                        double sweep_radius_m = 0.0)
      : SurfaceIndex({mesh.welded_positions(), mesh.faces(), map}, sweep_radius_m) {}
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  // The nearest surface point within radius_m of p. If several faces are equally near, the first
  // one found is returned.
  std::optional<SurfacePoint> closest_point(const Vec3& p, double radius_m) const noexcept;

  // The first point where the closed segment from p to p + d meets a closed triangle.
  std::optional<SegmentHit> first_hit(const Vec3& p, const Vec3& d) const noexcept;

  // Writes the ids of all packs whose box is within radius_m of p, in ascending order, and returns
  // their number. A result above packs.size() means that the search ended early, so that only some
  // ids were written.
  std::size_t packs_near(const Vec3& p, double radius_m, std::span<std::uint32_t> packs,
                         NearSearch search = NearSearch::kWithEmbree) const noexcept;

  // Like packs_near() above, but for all packs whose boxes meet a stretched ball around p.
  std::size_t packs_near(const Vec3& p, const StretchedBall& ball, std::span<std::uint32_t> packs,
                         NearSearch search) const noexcept;
  // Visits the packs that meet a stretched ball around p, roughly nearest first. Each call of the
  // visitor returns smaller or equal bounds for the rest of the search.
  void visit_nearest_packs(const Vec3& p, const StretchedBall& ball, NearestPackVisitor visitor,
                           void* state) const noexcept;

  // Visits all packs within radius_m <= sweep_radius_m of the segment p to p + d, roughly in order
  // along the segment, until the visitor ends the search. A segment of zero length visits no pack.
  void visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                     void* state) const noexcept;

  // Whether the segment p to p + d, grown by radius_m, meets the bounding box of the surface.
  bool may_meet(const Vec3& p, const Vec3& d, double radius_m) const noexcept;

  // Visits the same packs as visit_segment(), in an order that allows a search to stop at any pack
  // and resume there. With `first`, the order is ascending and starts at pack `first`. Without
  // `first`, it is the order in which the segment reaches the packs. If there are too many packs
  // for this order, it is used only for the packs near a first part of the segment. After them, all
  // packs are visited in ascending order.
  //
  // The visited packs and their grouping do not depend on the instruction set, whereas the order of
  // Embree's tree does. Returns the work beside that of the visitor.
  QueryWork visit_packs_along(const Vec3& p, const Vec3& d, double radius_m,
                              std::optional<std::uint32_t> first, OrderedPackVisitor visitor,
                              void* state) const noexcept;
  // Visits the packs of packs_near() in ascending order, starting at pack `first`. Returns the work
  // beside that of the visitor.
  QueryWork visit_packs_near(const Vec3& p, double radius_m, std::uint32_t first,
                             NearPackVisitor visitor, void* state) const noexcept;
  // Visits the packs whose boxes are within a radius of p, nearest boxes first in each group of
  // sixteen, in an order that does not depend on the instruction set. axes_per_radius: if given,
  // the half extents of a box around p, per unit of the radius, outside of which no pack is needed.
  void visit_nearest_in_order(const Vec3& p, double radius, const Vec3* axes_per_radius,
                              NearestVisitor visitor, void* state) const noexcept;

  // A slot identifies a triangle: slot n is lane n % kLanes of pack n / kLanes.
  static std::uint32_t slot(std::uint32_t pack, int lane) {
    return pack * TrianglePack::kLanes + static_cast<std::uint32_t>(lane);
  }
  const TriangleGeometry& triangle(std::uint32_t slot) const { return surface_.triangles[slot]; }
  std::uint32_t face(std::uint32_t slot) const { return surface_.faces[slot]; }
  // Prefetches into the cache the part of a pack that a trace reads.
  void prefetch_pack(std::uint32_t id) const {
    constexpr std::size_t kCacheLine = 64;
    const char* lines = reinterpret_cast<const char*>(&surface_.packs[id]);
    for (std::size_t i = 0; i < offsetof(TrianglePack, per_squared_edge); i += kCacheLine) {
      __builtin_prefetch(lines + i);
    }
  }
  // The boxes of the packs of one cluster, with rounding margins: lane n % kLanes of cluster n /
  // kLanes is the box of pack n.
  const BoxPack& cluster_boxes(std::uint32_t cluster) const { return cluster_boxes_[cluster]; }
  const TrianglePack& pack(std::uint32_t id) const { return surface_.packs[id]; }
  const TrianglePack* packs() const { return surface_.packs.data(); }
  std::size_t pack_count() const { return surface_.packs.size(); }
  const Box& box() const { return box_; }
  double mean_pack_diagonal_m() const { return mean_pack_diagonal_m_; }
  // Bound on the distance of a triangle from the centre of its pack along one axis.
  double largest_pack_reach_m() const { return largest_pack_reach_m_; }
  double sweep_radius_m() const { return sweep_radius_m_; }
  // Upper limit for every sweep radius, because Embree ignores boxes that extend beyond 1.8e18.
  static constexpr double kLargestSweep_m = 1e18;
  // The memory needed for an index of this number of triangles. The kept bytes of the result are
  // those that memory() reports.
  static MemoryNeed memory_need(std::uint64_t triangles);
  MemoryBreakdown memory() const;
  std::size_t memory_bytes() const { return memory().total(); }

 private:
  struct InOrder;

  std::vector<Box> build_clusters();
  template <typename Test>
  std::size_t packs_that_pass(const Test& test, std::span<std::uint32_t> packs,
                              NearSearch search) const noexcept;
  double grown_by_m(double radius_m) const { return float_margin_m_ + radius_m; }

  PackedSurface surface_;
  std::vector<BoxPack> cluster_boxes_;
  OrderedBoxes ordered_clusters_;
  Box box_;
  double sweep_radius_m_ = 0.0;
  double float_margin_m_ = 0.0;
  double mean_pack_diagonal_m_ = 0.0;
  double largest_pack_reach_m_ = 0.0;
  std::unique_ptr<EmbreeBoxes> clusters_;
};

}  // namespace palpate
