#pragma once

// The corners of a body's triangles as doubles of the solver frame, for bodies that meet others
// along a seam.
//
// Each body's index has a frame of its own, and a point is rounded on its way into each. So two
// bodies whose edges coincide in the file do not agree on which side of the edge a step passes, and
// a step may pass between them. In the solver frame there is one step and, for vertices that meet,
// one position: the signs about an edge that two bodies share are those of the same four points, as
// within one mesh.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// A corner is at most so many stand-offs from where the index, moved by the body's pose, has it,
// with the rounding of a point on its way to the index. What sorts out for the exact stage looks so
// much farther, and never leaves out a triangle that the exact stage would meet. It is less than
// SolverScale::kClearancePerStandOff, from farther than which a proxy comes: one whose body is
// judged by its corners in this tick, and by its index in the next because it moves, keeps its
// side.
inline constexpr double kMostApartPerStandOff = 0.2;

// Where the vertex of a mesh is, solver frame: its position in the mesh frame under the whole
// transform of its node, in one order of operations. It depends on nothing else, not on how the
// index is scaled or shared.
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

// A vertex that was made one with that of another body, and where that is. Solver frame, metres.
struct JoinedVertex {
  std::uint32_t vertex;  // welded, of the mesh
  Vec3 position_m;
};

// The corners of one body at rest. Immutable. Queries: no allocation, lock or exception;
// logarithmic in the joined vertices. What it is made from must outlive it.
class SolverCorners {
 public:
  // slots: the welded vertices of the triangles of the index, by slot, in their order in the mesh.
  // joined: in rising order of their vertices.
  SolverCorners(std::span<const Vec3> positions_mesh, std::span<const Triangle> slots,
                const Mat3& linear_solver_mesh, const Vec3& translation_solver_m,
                std::vector<JoinedVertex> joined);

  Vec3 vertex(std::uint32_t v) const noexcept;

  // The triangle of a slot, solver frame. normal_solver: is taken where the corners lie on one line
  // in double, as where the map of the node squeezes a thin triangle.
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
};

// The corners of all bodies of a world that have them.
struct SeamedBodies {
  std::vector<std::vector<Triangle>> slots;  // of each index that they have
  std::vector<std::unique_ptr<SolverCorners>> bodies;

  std::size_t memory_bytes() const;
};

// The welded vertices of every slot of an index over a mesh, in their order there.
std::vector<Triangle> vertices_of_slots(const SurfaceIndex& index, const SurfaceMesh& mesh);

}  // namespace palpate
