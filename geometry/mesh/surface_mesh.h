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

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/welded_surface.h"

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

// A WeldedSurface with adjacency. Immutable; safe to read from any thread. Not for use on the
// haptic thread, which works on a SurfaceIndex.
//
// Vertices are split until the surface is a consistently oriented 2-manifold with boundary, which
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

  SurfaceMesh() = default;  // none
  // Takes what only this object needs out of `welded`, whose positions and faces others may be
  // reading. Linear time.
  explicit SurfaceMesh(WeldedSurface& welded);

  // Of a triangle soup; see WeldedSurface.
  static SurfaceMesh build(std::vector<Vec3> positions, std::vector<Triangle> triangles);

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

  // Index into the triangles of the soup.
  std::uint32_t source_triangle(std::size_t face) const { return sources_.of_face(face); }
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

  // What that of a welded surface takes, beside the positions and the mates that it takes out of
  // it. Vertices that have several closed fans of faces are counted once.
  static MemoryNeed memory_need(const WeldedSurface& welded);
  MemoryBreakdown memory() const;
  std::size_t memory_bytes() const { return memory().total(); }

 private:
  std::vector<Vec3> points(std::vector<Vec3>& welded) const;

  // Shared because OpenMesh has no move, and this object is moved into results and scenes.
  std::shared_ptr<const OpenMeshSurface> surface_ = std::make_shared<const OpenMeshSurface>();
  SourceTriangles sources_;
  // The welded vertex of each split vertex that is not one itself.
  std::vector<std::uint32_t> copied_vertices_;
  // Edges that surface() cuts though two faces meet there.
  std::vector<MisalignedMate> cut_edges_;
  CleaningReport report_;
};

}  // namespace palpate
