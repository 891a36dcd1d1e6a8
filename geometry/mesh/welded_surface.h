#pragma once

// A cleaned triangle soup, the input of an index and of a surface with adjacency.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/source_triangles.h"
#include "geometry/mesh/surface_changes.h"

namespace palpate {

// The result of cleaning. triangles_in + added_triangles == triangles + dropped_degenerate +
// dropped_duplicate.
struct CleaningReport {
  std::size_t triangles_in = 0;
  std::size_t triangles = 0;           // faces of the surface
  std::size_t dropped_degenerate = 0;  // no area: a repeated position, or exactly collinear corners
  std::size_t dropped_duplicate = 0;   // the same three positions as an earlier triangle
  std::size_t welded_vertices = 0;     // distinct positions in use
  std::size_t split_vertices = 0;      // copies made so that OpenMesh accepts every face
  std::size_t boundary_edges = 0;      // welded edges with one face
  std::size_t non_manifold_edges = 0;  // welded edges with 3 or more faces, or 2 misaligned
  // Changes after exact welding (WeldedSurface::change()).
  std::size_t joined_edges = 0;     // pairs of boundary edges that became one edge
  std::size_t joined_vertices = 0;  // replaced by another vertex
  std::size_t divided_edges = 0;    // boundary edges divided at vertices that lie on them
  std::size_t added_triangles = 0;  // by the division of edges
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

  // The same surface, but positions() also has the distinct positions that no face uses.
  static WeldedSurface with_unused_positions(std::vector<Vec3> positions,
                                             std::vector<Triangle> triangles);

  // Applies the changes and cleans again: triangles without area and duplicate triangles are
  // dropped, and so are positions that no face uses. Faces, edges and vertices get new numbers, in
  // the same order; the pieces of a divided face follow each other. The report counts the changes.
  // Positions must stay distinct: vertices that meet must be merged. Must not be called after a
  // SurfaceMesh has been constructed from this object. O(n log n).
  void change(const SurfaceChanges& changes);
  // The memory that change() needs in addition to this object. divisions: at most this many.
  MemoryNeed memory_need_of_change(std::uint64_t divisions) const;
  void drop_unused_positions();
  WeldedSurface copy() const;

  std::size_t face_count() const { return faces_.size(); }
  // Indices of welded vertices.
  std::span<const Triangle> faces() const { return faces_; }
  // Distinct positions, each used by a face, in order of first occurrence.
  std::span<const Vec3> positions() const { return position_span_; }
  // Index of a face's triangle in the input.
  std::uint32_t source_triangle(std::size_t face) const { return sources_.of_face(face); }
  const SourceTriangles& sources() const { return sources_; }
  const HalfEdgeMates& mates() const { return mates_; }
  const CleaningReport& report() const { return report_; }  // split_vertices is not yet known

 private:
  friend class SurfaceMesh;

  void weld(std::vector<Vec3> positions, std::vector<Triangle> triangles);
  std::vector<std::uint32_t> find_duplicates() const;
  void drop_duplicates(std::vector<std::uint32_t>& dropped);
  void divide_faces(std::span<const EdgeDivision> divisions);
  void clean_again();
  void drop_faces(const std::vector<std::uint32_t>& dropped);
  void count();

  std::vector<Triangle> faces_;
  std::vector<Vec3> positions_;
  std::span<const Vec3> position_span_;  // of positions_; stays valid when they are moved
  HalfEdgeMates mates_;
  SourceTriangles sources_;
  CleaningReport report_;
};

}  // namespace palpate
