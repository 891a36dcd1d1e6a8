#pragma once

// A triangle soup made clean: what an index and a surface with adjacency are made of.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"

namespace palpate {

// What cleaning did. triangles_in == triangles + dropped_degenerate + dropped_duplicate.
struct CleaningReport {
  std::size_t triangles_in = 0;
  std::size_t triangles = 0;           // faces of the surface
  std::size_t dropped_degenerate = 0;  // no area: a repeated position, or exactly collinear corners
  std::size_t dropped_duplicate = 0;   // the same three positions as an earlier triangle
  std::size_t welded_vertices = 0;     // distinct positions in use
  std::size_t split_vertices = 0;      // copies made so that OpenMesh takes every face
  std::size_t boundary_edges = 0;      // welded edges with one face
  std::size_t non_manifold_edges = 0;  // welded edges with three faces or more, or two misoriented
};

// Which of the triangles that came in a face is, where some were dropped.
class SourceTriangles {
 public:
  SourceTriangles() = default;
  // dropped: numbers of triangles, rising.
  explicit SourceTriangles(const std::vector<std::uint32_t>& dropped);

  // O(log n) in the triangles that were dropped.
  std::uint32_t of_face(std::size_t face) const;
  std::size_t memory_bytes() const { return kept_before_.capacity() * sizeof(kept_before_[0]); }

 private:
  std::vector<std::uint32_t> kept_before_;  // of each that was dropped: how many kept ones. Rising
};

// A triangle surface in one frame (the caller's; positions in metres), made of any triangle soup.
//
// Cleaning, in order: positions that compare equal are welded (-0 as +0); triangles without area
// are dropped; of triangles with the same three positions, in any order, the first is kept.
//
// For load time. A SurfaceMesh takes out of it what only adjacency needs; that may happen while
// other threads read positions and faces, which stay valid as long as both objects.
class WeldedSurface {
 public:
  WeldedSurface() = default;  // none
  // positions: finite, metres. triangles: indices into positions, all in range, fewer than 3e8
  // (checked by asserts: a reader must have refused such a file before). The same for any number
  // of threads. O(n log n).
  WeldedSurface(std::vector<Vec3> positions, std::vector<Triangle> triangles);

  // What it takes to make one of so many positions and triangles, beside those.
  static MemoryNeed memory_need(std::uint64_t positions, std::uint64_t triangles);

  std::size_t face_count() const { return faces_.size(); }
  // In welded vertices.
  std::span<const Triangle> faces() const { return faces_; }
  // Distinct, each in use, in order of first occurrence.
  std::span<const Vec3> positions() const { return position_span_; }
  // Index into the triangles that it was made of.
  std::uint32_t source_triangle(std::size_t face) const { return sources_.of_face(face); }
  const HalfEdgeMates& mates() const { return mates_; }
  const CleaningReport& report() const { return report_; }  // split_vertices: not yet known

 private:
  friend class SurfaceMesh;

  void drop_duplicates(std::vector<std::uint32_t>& dropped);
  void drop_unused_positions();

  std::vector<Triangle> faces_;
  std::vector<Vec3> positions_;
  std::span<const Vec3> position_span_;  // of positions_, and of where they are moved to
  HalfEdgeMates mates_;
  SourceTriangles sources_;
  CleaningReport report_;
};

}  // namespace palpate
