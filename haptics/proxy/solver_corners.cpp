#include "haptics/proxy/solver_corners.h"

#include <algorithm>
#include <utility>

#include "geometry/exact/exact.h"

namespace palpate {

SolverCorners::SolverCorners(std::span<const Vec3> positions_mesh, std::span<const Triangle> slots,
                             const Mat3& linear_solver_mesh, const Vec3& translation_solver_m,
                             std::vector<JoinedVertex> joined, bool are_for_contacts)
    : positions_mesh_(positions_mesh),
      slots_(slots),
      linear_solver_mesh_(linear_solver_mesh),
      is_mirrored_(linear_solver_mesh.determinant() < 0.0),
      translation_solver_m_(translation_solver_m),
      joined_(std::move(joined)),
      are_for_contacts_(are_for_contacts) {}

Vec3 SolverCorners::vertex(std::uint32_t v) const noexcept {
  const auto found = std::lower_bound(
      joined_.begin(), joined_.end(), v,
      [](const JoinedVertex& joined, std::uint32_t sought) { return joined.vertex < sought; });
  if (found != joined_.end() && found->vertex == v) return found->position_m;
  return solver_vertex(linear_solver_mesh_, translation_solver_m_, positions_mesh_[v]);
}

TriangleGeometry SolverCorners::triangle(std::uint32_t slot,
                                         const Vec3& normal_solver) const noexcept {
  Triangle corners = slots_[slot];
  if (is_mirrored_) std::swap(corners[1], corners[2]);
  TriangleGeometry t{vertex(corners[0]), vertex(corners[1]), vertex(corners[2]), normal_solver};
  if (!exactly_collinear(t.a, t.b, t.c)) t.normal = accurate_unit_normal(t.a, t.b, t.c);
  return t;
}

std::size_t SeamedBodies::memory_bytes() const {
  std::size_t bytes =
      sizeof(*this) + slots.capacity() * sizeof(slots[0]) + bodies.capacity() * sizeof(bodies[0]);
  for (const std::vector<Triangle>& of_index : slots)
    bytes += of_index.capacity() * sizeof(Triangle);
  for (const auto& body : bodies) bytes += body->memory_bytes();
  return bytes;
}

std::vector<Triangle> vertices_of_slots(const SurfaceIndex& index, const SurfaceMesh& mesh) {
  std::vector<Triangle> slots(index.pack_count() * TrianglePack::kLanes);
  for (std::uint32_t slot = 0; slot < slots.size(); ++slot) {
    slots[slot] = mesh.face(index.face(slot));
  }
  return slots;
}

}  // namespace palpate
