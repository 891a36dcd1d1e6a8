#pragma once

// Spatial queries on a surface: Embree finds clusters of triangles, double precision decides.

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
  std::uint32_t face;  // of the SurfaceMesh
};

// Where a segment first meets the surface.
struct SegmentHit {
  double fraction;  // of the segment, in [0, 1]
  Vec3 point_m;
  std::uint32_t face;
};

// What holds a ball that has been stretched: a ball, and a box, by its half extents.
struct StretchedBall {
  double radius_m;
  Vec3 by_axis_m;
};

// The triangles of a surface in the order of their packs: slot n is lane n % kLanes of pack
// n / kLanes. Slots past a pack's count repeat its last triangle. Packs n kLanes to
// (n + 1) kLanes - 1 lie close together, too: cluster n.
struct PackedSurface {
  FixedArray<TrianglePack> packs;
  FixedArray<Box> boxes;                   // of the packs; not kept in an index
  FixedArray<TriangleGeometry> triangles;  // a slot each, in double: what decides
  FixedArray<std::uint32_t> faces;         // a slot each: of the mesh
};

// What a visitor of a segment returns to see nothing more at all, not even at the start.
inline constexpr QueryFraction kNothingMore{-1.0};

// Called with up to sixteen packs near a segment; returns the fraction of the segment beyond which
// packs are of no interest any more (its end to see them all), or kNothingMore. Must not throw.
using PackVisitor = QueryFraction (*)(void* state, std::span<const std::uint32_t> packs);

// Called with up to sixteen packs; returns the fraction of the segment beyond which packs are of no
// interest any more (its end to see them all), or kNothingMore. in_order: they are in ascending
// order, and all before them have been visited. Must not throw.
using OrderedPackVisitor = QueryFraction (*)(void* state, std::span<const std::uint32_t> packs,
                                             bool in_order);
// Called with a pack; returns how far around the point packs are still of interest. Must not throw.
using NearestPackVisitor = StretchedBall (*)(void* state, std::uint32_t pack);
// Called with up to sixteen packs, in ascending order; returns whether more are wanted.
using NearPackVisitor = bool (*)(void* state, std::span<const std::uint32_t> packs);

// An immutable index over one surface, in a frame of its own (the index frame), which should have
// its origin near the middle of the surface: then nothing is lost to large coordinates. Embree's
// BVH finds clusters of sixteen packs of sixteen triangles; within those, boxes and then triangles
// are sorted out sixteen at a time. All that is single precision and only narrows the search: boxes
// are grown by the roundings (kFloatMarginUlps), and every answer is decided on
// double vertices.
//
// Queries: no allocation, lock or exception; thread-safe; safe on the haptic thread. Query points
// must be finite.
class SurfaceIndex {
 public:
  // sweep_radius_m: largest radius that visit_segment() will be asked for. Uses all cores; the same
  // for any number of them.
  explicit SurfaceIndex(const MappedFaces& faces, double sweep_radius_m = 0.0);
  explicit SurfaceIndex(const SurfaceMesh& mesh, const AffineMap& map = {},
                        double sweep_radius_m = 0.0)
      : SurfaceIndex({mesh.welded_positions(), mesh.faces(), map}, sweep_radius_m) {}
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  // The nearest surface point at most radius_m away; of equally near faces the one found first.
  std::optional<SurfacePoint> closest_point(const Vec3& p, double radius_m) const noexcept;

  // First point where the closed segment from p to p + d meets a closed triangle.
  std::optional<SegmentHit> first_hit(const Vec3& p, const Vec3& d) const noexcept;

  // Writes the ids of all packs whose box comes within radius_m of p, ascending. Returns how many
  // there are; when that exceeds packs.size(), only some were written and the search ended early.
  std::size_t packs_near(const Vec3& p, double radius_m, std::span<std::uint32_t> packs,
                         NearSearch search = NearSearch::kWithEmbree) const noexcept;

  // The same of all packs whose boxes come into a ball that has been stretched, around p.
  std::size_t packs_near(const Vec3& p, const StretchedBall& ball, std::span<std::uint32_t> packs,
                         NearSearch search) const noexcept;
  // Visits those packs, the nearest first, roughly, until nothing is left of what is of interest.
  void visit_nearest_packs(const Vec3& p, const StretchedBall& ball, NearestPackVisitor visitor,
                           void* state) const noexcept;

  // Visits all packs that come within radius_m <= sweep_radius_m of the segment p to p + d,
  // roughly in order along it, until the visitor says that the rest is of no interest. A segment of
  // no length visits nothing.
  void visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                     void* state) const noexcept;

  // Whether there is anything to visit: the segment, grown by radius_m, meets the index's box.
  bool may_meet(const Vec3& p, const Vec3& d, double radius_m) const noexcept;

  // Visits the same packs so that a search can end anywhere and go on from there: in ascending
  // order, from number `first` on if it is given. If not, those that the segment comes near first
  // come first; where there are very many, in the first part of it, and then all in ascending
  // order. Which packs they are and how they are grouped does not depend on the instruction set,
  // unlike the boxes that Embree's tree leads to. Returns how many more were found, but not visited
  // in that turn, because there were too many.
  std::size_t visit_packs_along(const Vec3& p, const Vec3& d, double radius_m,
                                std::optional<std::uint32_t> first, OrderedPackVisitor visitor,
                                void* state) const noexcept;
  // Visits the packs that packs_near() writes in ascending order, from number `first` on.
  void visit_packs_near(const Vec3& p, double radius_m, std::uint32_t first,
                        NearPackVisitor visitor, void* state) const noexcept;

  // Triangles are named by slots: slot n is lane n % kLanes of pack n / kLanes.
  static std::uint32_t slot(std::uint32_t pack, int lane) {
    return pack * TrianglePack::kLanes + static_cast<std::uint32_t>(lane);
  }
  const TriangleGeometry& triangle(std::uint32_t slot) const { return surface_.triangles[slot]; }
  std::uint32_t face(std::uint32_t slot) const { return surface_.faces[slot]; }
  // Starts to bring what a trace asks of a pack into the cache, to be used a little later.
  void prefetch_pack(std::uint32_t id) const {
    constexpr std::size_t kCacheLine = 64;
    const char* lines = reinterpret_cast<const char*>(&surface_.packs[id]);
    for (std::size_t i = 0; i < offsetof(TrianglePack, per_squared_edge); i += kCacheLine) {
      __builtin_prefetch(lines + i);
    }
  }
  // Box n % kLanes of entry n / kLanes is around pack n, with margins for rounding.
  const BoxPack& cluster_boxes(std::uint32_t cluster) const { return cluster_boxes_[cluster]; }
  const TrianglePack& pack(std::uint32_t id) const { return surface_.packs[id]; }
  const TrianglePack* packs() const { return surface_.packs.data(); }
  std::size_t pack_count() const { return surface_.packs.size(); }
  const Box& box() const { return box_; }
  double mean_pack_diagonal_m() const { return mean_pack_diagonal_m_; }
  // How far a triangle may reach from the centre of its pack, at most, along one axis.
  double largest_pack_reach_m() const { return largest_pack_reach_m_; }
  double sweep_radius_m() const { return sweep_radius_m_; }
  // No sweep is larger, whatever the index was built for: Embree leaves out boxes that reach beyond
  // 1.8e18.
  static constexpr double kLargestSweep_m = 1e18;
  // What an index of so many triangles takes, and memory() will be.
  static MemoryNeed memory_need(std::uint64_t triangles);
  MemoryBreakdown memory() const;
  std::size_t memory_bytes() const { return memory().total(); }

 private:
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
