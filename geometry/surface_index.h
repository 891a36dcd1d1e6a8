#pragma once

// Spatial queries on a surface: Embree finds packs of triangles, double precision decides.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/surface_mesh.h"
#include "geometry/triangle.h"
#include "geometry/types.h"

namespace palpate {

// Eight neighbouring triangles, one lane each, coordinates in the frame of the index (metres).
// Lanes past `count` repeat the last triangle, so that a loop over all lanes is always valid.
struct alignas(64) TrianglePack {
  static constexpr int kLanes = 8;
  double a[3][kLanes];
  double b[3][kLanes];
  double c[3][kLanes];
  double normal[3][kLanes];  // unit, from a 113-bit cross product
  std::uint32_t face[kLanes];
  int count;

  TriangleGeometry triangle(int lane) const {
    const auto at = [lane](const double(&m)[3][kLanes]) {
      return Vec3(m[0][lane], m[1][lane], m[2][lane]);
    };
    return {at(a), at(b), at(c), at(normal)};
  }
};

// An axis-aligned box in the frame of the index, metres.
struct Box {
  Vec3 low, high;
  double squared_distance(const Vec3& p) const {
    return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
  }
  Box grown(double margin) const {
    return {(low.array() - margin).matrix(), (high.array() + margin).matrix()};
  }
  // Narrows [enter, leave] to the part of p + [enter, leave] d inside; false if there is none.
  bool clip(const Vec3& p, const Vec3& d, double& enter, double& leave) const;
};

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

// p_index = linear * p_mesh + translation_m: how a surface is placed in the frame of its index.
struct AffineMap {
  Mat3 linear = Mat3::Identity();  // not singular; a mirror turns the faces over again
  Vec3 translation_m = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return linear * p + translation_m; }
};

// Called for a pack near a segment; returns the fraction of the segment beyond which packs are of
// no interest any more (1 to see them all). Must not throw.
using PackVisitor = double (*)(void* state, std::uint32_t pack);

// An immutable index over one surface, in a frame of its own (the index frame), which should have
// its origin near the middle of the surface: then nothing is lost to large coordinates. Embree
// works in single precision, so it only narrows the search: its boxes are grown by kFloatMarginUlps
// ulp of the largest float coordinate, and every answer is decided on double vertices.
//
// Queries: no allocation, lock or exception; thread-safe; safe on the haptic thread. Query points
// must be finite.
class SurfaceIndex {
 public:
  // How far a float box may be off: rounding of the box (1 ulp), of the query point (1), of a ray's
  // origin, direction and end (4), with as much again in hand.
  static constexpr int kFloatMarginUlps = 12;

  // sweep_radius_m: largest radius that visit_segment() will be asked for.
  explicit SurfaceIndex(const SurfaceMesh& mesh, const AffineMap& map = {},
                        double sweep_radius_m = 0.0);
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  // The nearest surface point at most radius_m away; of equally near faces the one found first.
  std::optional<SurfacePoint> closest_point(const Vec3& p, double radius_m) const noexcept;

  // First point where the closed segment from p to p + d meets a closed triangle.
  std::optional<SegmentHit> first_hit(const Vec3& p, const Vec3& d) const noexcept;

  // Writes the ids of all packs whose box comes within radius_m of p. Returns how many there are;
  // when that exceeds packs.size(), the surplus was not written and the search ended early.
  std::size_t packs_near(const Vec3& p, double radius_m,
                         std::span<std::uint32_t> packs) const noexcept;

  // Visits every pack that comes within radius_m <= sweep_radius_m of the segment p to p + d,
  // roughly in order along it, until the visitor says that the rest is of no interest. A segment of
  // no length visits nothing.
  void visit_segment(const Vec3& p, const Vec3& d, double radius_m, PackVisitor visitor,
                     void* state) const noexcept;

  const TrianglePack& pack(std::uint32_t id) const { return packs_[id]; }
  std::size_t pack_count() const { return packs_.size(); }
  const Box& box() const { return box_; }
  double mean_pack_diagonal_m() const { return mean_pack_diagonal_m_; }
  double sweep_radius_m() const { return sweep_radius_m_; }
  std::size_t memory_bytes() const;

 private:
  struct EmbreeScene;

  std::vector<TrianglePack> packs_;
  std::vector<Box> pack_boxes_;
  Box box_;
  double sweep_radius_m_ = 0.0;
  double float_margin_m_ = 0.0;
  double mean_pack_diagonal_m_ = 0.0;
  std::unique_ptr<EmbreeScene> scene_;
};

}  // namespace palpate
