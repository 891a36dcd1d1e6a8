#pragma once

// A cleaned triangle soup, the input of an index and of a surface with adjacency.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"

namespace palpate {

// The result of cleaning. triangles_in == triangles + dropped_degenerate + dropped_duplicate.
struct CleaningReport {
  std::size_t triangles_in = 0;
  std::size_t triangles = 0;           // faces of the surface
  std::size_t dropped_degenerate = 0;  // no area: a repeated position, or exactly collinear corners
  std::size_t dropped_duplicate = 0;   // the same three positions as an earlier triangle
  std::size_t welded_vertices = 0;     // distinct positions in use
  std::size_t split_vertices = 0;      // copies made so that OpenMesh accepts every face
  std::size_t boundary_edges = 0;      // welded edges with one face
  std::size_t non_manifold_edges = 0;  // welded edges with 3 or more faces, or 2 misaligned
};

// Maps a face to its input triangle after some triangles were dropped.
class SourceTriangles {
 public:
  SourceTriangles() = default;
  // dropped: numbers of the dropped triangles, ascending.
  explicit SourceTriangles(const std::vector<std::uint32_t>& dropped);

  // O(log n) in the number of dropped triangles.
  std::uint32_t of_face(std::size_t face) const;
  std::size_t memory_bytes() const { return kept_before_.capacity() * sizeof(kept_before_[0]); }

 private:
  // The number of kept triangles before each dropped triangle; ascending.
  std::vector<std::uint32_t> kept_before_;
};

// A triangle surface made from any triangle soup. Positions are in metres in the caller's frame.
//
// Cleaning, in order: positions that compare equal are welded (-0 equals +0); triangles without
// area are dropped; if several triangles have the same three positions, in any order, the first one
// is kept.
//
// Load time only. A SurfaceMesh moves the data that only adjacency needs out of this object. Other
// threads may read positions and faces at the same time. Positions and faces stay valid while both
// this object and the SurfaceMesh exist.
class WeldedSurface {
 public:
  WeldedSurface() = default;  // no faces
  // positions: finite, metres. triangles: indices into positions, all in range, fewer than 3e8
  // (checked by asserts: a reader must reject other files). The result does not depend on the
  // number of threads. O(n log n).
  WeldedSurface(std::vector<Vec3> positions, std::vector<Triangle> triangles);

  // The memory needed to build a surface from these numbers of positions and triangles, in addition
  // to the input.
  static MemoryNeed memory_need(std::uint64_t positions, std::uint64_t triangles);

  std::size_t face_count() const { return faces_.size(); }
  // Indices of welded vertices.
  std::span<const Triangle> faces() const { return faces_; }
  // Distinct positions, each used by a face, in order of first occurrence.
  std::span<const Vec3> positions() const { return position_span_; }
  // Index of a face's triangle in the input.
  std::uint32_t source_triangle(std::size_t face) const { return sources_.of_face(face); }
  const HalfEdgeMates& mates() const { return mates_; }
  const CleaningReport& report() const { return report_; }  // split_vertices is not yet known

 private:
  friend class SurfaceMesh;

  void drop_duplicates(std::vector<std::uint32_t>& dropped);
  void drop_unused_positions();

  std::vector<Triangle> faces_;
  std::vector<Vec3> positions_;
  std::span<const Vec3> position_span_;  // of positions_; stays valid when they are moved
  HalfEdgeMates mates_;
  SourceTriangles sources_;
  CleaningReport report_;
};

}  // namespace palpate
