#pragma once

// A welded, cleaned triangle surface with adjacency.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
// Only compiles after the other.
#include <OpenMesh/Core/Geometry/EigenVectorT.hh>

#include "geometry/half_edges.h"
#include "geometry/memory_breakdown.h"
#include "geometry/types.h"

// OpenMesh appends T() before it sets a position, which leaves one of Eigen's unset, and GCC warns
// of the copy.
template <>
inline void OpenMesh::PropertyT<palpate::Vec3>::push_back() {
  data_.push_back(palpate::Vec3::Zero());
}

namespace palpate {

struct OpenMeshTraits : OpenMesh::DefaultTraits {
  using Point = Vec3;
  using Normal = Vec3;
};
using OpenMeshSurface = OpenMesh::TriMesh_ArrayKernelT<OpenMeshTraits>;

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

// A triangle surface in one frame (the caller's; positions in metres), made of any triangle soup.
// Immutable after build; safe to read from any thread. Not for use on the haptic thread, which
// works on the SurfaceIndex made from it.
//
// Cleaning, in order: positions that compare equal are welded (-0 as +0); triangles without area
// are dropped; of triangles with the same three positions, in any order, the first is kept. Then
// vertices are split until the surface is a consistently oriented 2-manifold with boundary, which
// OpenMesh requires: two corners stay together only across an edge that has exactly two faces
// oriented alike. No face that has area is lost.
//
// OpenMesh's add_face() would accept the faces of surface() in any order. Where a fan comes back to
// an edge that a third face was cut off from, surface() has two boundary edges with the same ends,
// which add_face() would join.
//
// A large surface is mostly OpenMesh's 72 bytes a triangle: what follows from that, such as
// face(), is not kept a second time.
class SurfaceMesh {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  // positions: finite, metres. triangles: indices into positions, all in range, fewer than 3e8
  // (checked by asserts: a reader must have refused such a file before). O(n log n).
  static SurfaceMesh build(const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& triangles);

  // Adjacency and boundaries of the split surface. Face i of it is face i here, its vertices
  // starting with the same corner. No normals: accurate_unit_normal() gives that of a face.
  const OpenMeshSurface& surface() const { return *surface_; }
  const CleaningReport& report() const { return report_; }

  std::size_t face_count() const { return report_.triangles; }
  // The welded vertices of a face, in its own orientation.
  Triangle face(std::size_t f) const;
  // Those of all faces, made anew.
  std::vector<Triangle> faces() const;
  // The first vertices of surface(). Valid as long as this object or a copy of it.
  std::span<const Vec3> welded_positions() const {
    return {surface_->points(), report_.welded_vertices};
  }

  // Index into the triangles given to build(). O(log n) in the triangles that were dropped.
  std::uint32_t source_triangle(std::size_t face) const;
  // Welded vertex of a vertex of surface().
  std::uint32_t welded_vertex(std::size_t split_vertex) const {
    return split_vertex < report_.welded_vertices
               ? static_cast<std::uint32_t>(split_vertex)
               : copied_vertices_[split_vertex - report_.welded_vertices];
  }
  // The one other face across edge e of a face (from its corner e to corner e + 1) in the welded
  // surface, also where the split surface is cut for orientation; kNone at a boundary or where
  // three faces or more meet. O(log n) in the edges cut for orientation.
  std::uint32_t welded_neighbour(std::size_t face, int e) const;

  MemoryBreakdown memory() const;
  std::size_t memory_bytes() const { return memory().total(); }

 private:
  // Shared because OpenMesh has no move, and this object is moved into results and scenes.
  std::shared_ptr<const OpenMeshSurface> surface_ = std::make_shared<const OpenMeshSurface>();
  // Per dropped triangle, how many before it were kept.
  std::vector<std::uint32_t> kept_before_dropped_;
  // The welded vertex of each split vertex that is not one itself.
  std::vector<std::uint32_t> copied_vertices_;
  // Edges that surface() cuts though two faces meet there.
  std::vector<MisalignedMate> cut_edges_;
  CleaningReport report_;
};

}  // namespace palpate
