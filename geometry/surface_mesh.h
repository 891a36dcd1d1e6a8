#pragma once

// A welded, cleaned triangle surface with adjacency.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "geometry/types.h"

namespace palpate {

struct OpenMeshTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
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
class SurfaceMesh {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  // positions: finite, metres. triangles: indices into positions, all in range, fewer than 3e8
  // (checked by asserts: a reader must have refused such a file before). O(n log n).
  static SurfaceMesh build(const std::vector<Vec3>& positions,
                           const std::vector<Triangle>& triangles);

  // Adjacency, normals and boundaries of the split surface. Face i of it is face i here, its
  // vertices starting with the same corner. Face normals are accurate_unit_normal(); vertex normals
  // are OpenMesh's unweighted mean of them, unit, or zero where they cancel.
  const OpenMeshSurface& surface() const { return *surface_; }
  const CleaningReport& report() const { return report_; }

  std::size_t face_count() const { return faces_.size(); }
  // The welded vertices of a face, in its own orientation.
  const Triangle& face(std::size_t f) const { return faces_[f]; }
  const std::vector<Triangle>& faces() const { return faces_; }
  const std::vector<Vec3>& welded_positions() const { return welded_positions_; }

  // Index into the triangles given to build().
  std::uint32_t source_triangle(std::size_t face) const { return source_triangle_[face]; }
  // Welded vertex of a vertex of surface().
  std::uint32_t welded_vertex(std::size_t split_vertex) const {
    return welded_vertex_[split_vertex];
  }
  // The one other face across edge e of a face (from its corner e to corner e + 1) in the welded
  // surface, also where the split surface is cut for orientation; kNone at a boundary or where
  // three faces or more meet.
  std::uint32_t welded_neighbour(std::size_t face, int e) const {
    return welded_neighbours_[face][static_cast<std::size_t>(e)];
  }

  std::size_t memory_bytes() const;

 private:
  // Shared because OpenMesh has no move, and this object is moved into results and scenes.
  std::shared_ptr<const OpenMeshSurface> surface_ = std::make_shared<const OpenMeshSurface>();
  std::vector<Vec3> welded_positions_;
  std::vector<Triangle> faces_;
  std::vector<std::uint32_t> source_triangle_;
  std::vector<std::uint32_t> welded_vertex_;
  std::vector<Triangle> welded_neighbours_;
  CleaningReport report_;
};

}  // namespace palpate
