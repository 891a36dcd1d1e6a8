#pragma once

// A welded, cleaned triangle surface with adjacency.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
// This header compiles only after the one above.
#include <OpenMesh/Core/Geometry/EigenVectorT.hh>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/welded_surface.h"

// OpenMesh appends T() before it sets a position. For an Eigen vector, T() is uninitialised, and
// GCC warns about copying it. This specialisation therefore appends zeros.
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

// A WeldedSurface with adjacency. Immutable; safe to read from any thread. Not for use on the
// haptic thread, which works on a SurfaceIndex.
//
// Vertices are split until the surface is a consistently oriented 2-manifold with boundary, as
// OpenMesh requires. Two faces share a vertex only if they are connected around it through edges
// that each have exactly two faces, oriented alike. Every face with an area is kept.
//
// If the faces of surface() were given to OpenMesh's add_face(), in any order, the result would be
// the same surface, with one exception. At an edge with three or more faces, surface() connects no
// two of them. If a fan of faces begins and ends at such an edge, surface() can have two boundary
// edges with the same two end vertices. add_face() would join these two edges into one.
//
// OpenMesh uses 72 bytes per triangle, most of the memory of a large surface. Data that can be
// derived from OpenMesh, such as face(), is not stored again.
class SurfaceMesh {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  SurfaceMesh() = default;  // no faces
  // Moves the data that only this object needs out of `welded`. Other threads may read the
  // positions and faces of `welded` at the same time. Linear time.
  explicit SurfaceMesh(WeldedSurface& welded);

  // Builds the surface of a triangle soup; see WeldedSurface.
  static SurfaceMesh build(std::vector<Vec3> positions, std::vector<Triangle> triangles);

  // Adjacency and boundaries of the split surface. Face numbers and the first corner of each face
  // are the same as in this object. OpenMesh's normals are not set; use accurate_unit_normal().
  const OpenMeshSurface& surface() const { return *surface_; }
  const CleaningReport& report() const { return report_; }

  std::size_t face_count() const { return report_.triangles; }
  // The welded vertices of a face, in its own orientation.
  Triangle face(std::size_t f) const;
  // The welded vertices of all faces, computed on each call.
  std::vector<Triangle> faces() const;
  // The positions of the welded vertices, which are the first vertices of surface(). Valid for the
  // lifetime of this object and its copies.
  std::span<const Vec3> welded_positions() const {
    return {surface_->points(), report_.welded_vertices};
  }

  // Index into the triangles of the soup.
  std::uint32_t source_triangle(std::size_t face) const { return sources_.of_face(face); }
  // The piece of the source triangle that a face is; null if the face is the whole triangle.
  const FacePiece* piece(std::size_t face) const { return sources_.piece(face); }
  // The welded vertex of a vertex of surface().
  std::uint32_t welded_vertex(std::size_t split_vertex) const {
    return split_vertex < report_.welded_vertices
               ? static_cast<std::uint32_t>(split_vertex)
               : copied_vertices_[split_vertex - report_.welded_vertices];
  }
  // The only other face at edge e of a face in the welded surface. Edge e runs from corner e to
  // corner e + 1. Edges that surface() cuts because of orientation are included. kNone at a
  // boundary edge or where three or more faces meet. O(log n) in the number of edges cut because of
  // orientation.
  std::uint32_t welded_neighbour(std::size_t face, int e) const;

  // The memory needed for the SurfaceMesh of `welded`, excluding the positions and mates that are
  // moved out of `welded`. Vertices with several closed fans of faces are counted once.
  static MemoryNeed memory_need(const WeldedSurface& welded);
  MemoryBreakdown memory() const;
  std::size_t memory_bytes() const { return memory().total(); }

 private:
  std::vector<Vec3> points(std::vector<Vec3>& welded) const;

  // The surface is shared, because OpenMesh has no move constructor and this object is moved into
  // results and scenes.
  std::shared_ptr<const OpenMeshSurface> surface_ = std::make_shared<const OpenMeshSurface>();
  SourceTriangles sources_;
  // The welded vertex of each split vertex that is a copy.
  std::vector<std::uint32_t> copied_vertices_;
  // The edges that surface() cuts because of orientation. Each of them has exactly two faces.
  std::vector<MisalignedMate> cut_edges_;
  CleaningReport report_;
};

}  // namespace palpate
