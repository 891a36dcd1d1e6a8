#pragma once

// The corners of a body's triangles as doubles in the solver frame, for bodies that meet others
// along a seam.
//
// Each body has its own index frame, and the transformation of a point into it rounds the point.
// Two bodies whose edges coincide in the file may therefore disagree on which side of the edge a
// step passes, and the step may slip between them. In the solver frame the step has one pair of end
// points, and vertices that meet have one position. For a shared edge, both bodies then compute the
// orientation signs from the same four points, as two triangles of one mesh do.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// The largest distance, in stand-offs, between a corner in the solver frame and the same corner of
// the index after the body's pose has moved it. The rounding of a point that is transformed to the
// index is included. The stages before the exact test extend their search by this distance, so that
// they never exclude a triangle that the exact test would hit. The distance is less than
// SolverScale::kClearancePerStandOff, the least clearance of a proxy. A proxy therefore keeps its
// side when a body begins to move and its index replaces its corners from one tick to the next.
inline constexpr double kMostApartPerStandOff = 0.2;

// The position of a mesh vertex in the solver frame, m. The complete transform of the vertex's node
// is applied to the position in the mesh frame, in a fixed order of operations. The result does not
// depend on the scale or the sharing of the index.
inline Vec3 solver_vertex(const Mat3& linear_solver_mesh, const Vec3& translation_solver_m,
                          const Vec3& v_mesh) {
  const Mat3& m = linear_solver_mesh;
  Vec3 p;
  for (int i = 0; i < 3; ++i) {
    p[i] =
        m(i, 0) * v_mesh[0] + m(i, 1) * v_mesh[1] + m(i, 2) * v_mesh[2] + translation_solver_m[i];
  }
  return p;
}

// A vertex that was joined with a vertex of another body, and their common position.
struct JoinedVertex {
  std::uint32_t vertex;  // number of the welded vertex in the mesh
  Vec3 position_m;       // solver frame
};

// The corners of one body at rest. Immutable, therefore thread-safe. Queries are safe on the haptic
// thread (no allocation, lock or exception) and take logarithmic time in the number of joined
// vertices. The positions and slots given must outlive the object.
class SolverCorners {
 public:
  // slots: for each slot of the index, the welded vertices of its triangle in mesh order.
  // joined: sorted by vertex in ascending order.
  // are_for_contacts: whether contacts are computed with these corners, too. False when a recording
  // of before is replayed, whose contacts were computed in the body frame.
  SolverCorners(std::span<const Vec3> positions_mesh, std::span<const Triangle> slots,
                const Mat3& linear_solver_mesh, const Vec3& translation_solver_m,
                std::vector<JoinedVertex> joined, bool are_for_contacts = true);

  bool are_for_contacts() const { return are_for_contacts_; }

  // The position of a welded vertex, solver frame, m.
  Vec3 vertex(std::uint32_t v) const noexcept;

  // The triangle of a slot, solver frame, m. normal_solver (unit) replaces the computed normal if
  // the corners are collinear in double, for example a thin triangle that the node's transform
  // squeezes.
  TriangleGeometry triangle(std::uint32_t slot, const Vec3& normal_solver) const noexcept;

  std::span<const JoinedVertex> joined() const { return joined_; }
  std::size_t memory_bytes() const {
    return sizeof(*this) + joined_.capacity() * sizeof(JoinedVertex);
  }

 private:
  std::span<const Vec3> positions_mesh_;
  std::span<const Triangle> slots_;
  Mat3 linear_solver_mesh_;
  bool is_mirrored_;
  Vec3 translation_solver_m_;
  std::vector<JoinedVertex> joined_;
  bool are_for_contacts_;
};

// Owns the corners of all bodies of a world that have seams.
struct SeamedBodies {
  std::vector<std::vector<Triangle>> slots;  // vertices_of_slots() of each index
  std::vector<std::unique_ptr<SolverCorners>> bodies;

  std::size_t memory_bytes() const;
};

// The welded vertices of the triangle in every slot of an index over a mesh, in mesh order.
// Allocates; not for the haptic thread.
std::vector<Triangle> vertices_of_slots(const SurfaceIndex& index, const SurfaceMesh& mesh);

}  // namespace palpate
