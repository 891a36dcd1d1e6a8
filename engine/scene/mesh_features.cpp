#include "engine/scene/mesh_features.h"

#include <cmath>

namespace palpate {
namespace {

std::vector<Box> boxes_of_faces(const WeldedSurface& mesh) {
  std::vector<Box> boxes;
  boxes.reserve(mesh.face_count());
  for (const Triangle& t : mesh.faces()) {
    Box box = Box::empty();
    for (const std::uint32_t v : t) box = box.united({mesh.positions()[v], mesh.positions()[v]});
    boxes.push_back(box);
  }
  return boxes;
}

// Whether the corner opposite to the mate of a half-edge lies in the plane of the half-edge's face.
// With the barycentric coordinates w of the corner in this plane, errors of all four vertices give
// it a height of up to error_m (1 + |w_a| + |w_b| + |w_c|).
bool is_in_plane(const WeldedSurface& mesh, std::uint32_t half_edge, std::uint32_t mate,
                 double error_m) {
  const Triangle& face = mesh.faces()[half_edge / 3];
  const Vec3& a = mesh.positions()[face[0]];
  const Vec3 ab = mesh.positions()[face[1]] - a;
  const Vec3 ac = mesh.positions()[face[2]] - a;
  const Vec3 normal = ab.cross(ac);
  const std::uint32_t opposite = mesh.faces()[mate / 3][previous_half_edge(mate) % 3];
  const Vec3 ad = mesh.positions()[opposite] - a;
  // All multiplied by the square of the normal, since a face may have no area.
  const double one = normal.squaredNorm();
  const double w_b = ad.cross(ac).dot(normal);
  const double w_c = ab.cross(ad).dot(normal);
  const double errors = one + std::abs(one - w_b - w_c) + std::abs(w_b) + std::abs(w_c);
  return std::abs(normal.dot(ad)) * normal.norm() <= errors * error_m;
}

}  // namespace

MeshFeatures::MeshFeatures(const WeldedSurface& mesh, double error_m)
    : tree_(boxes_of_faces(mesh)),
      starts_(3 * mesh.face_count()),
      first_(mesh.positions().size() + 1, 0),
      edges_(3 * mesh.face_count(), Edge{true, true}),
      sharp_vertices_(mesh.positions().size(), false) {
  const std::span<const Triangle> faces = mesh.faces();
  for (const Triangle& t : faces) {
    for (const std::uint32_t v : t) ++first_[v + 1];
  }
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t h = 0; h < starts_.size(); ++h) starts_[next[faces[h / 3][h % 3]]++] = h;
  for (std::uint32_t h = 0; h < starts_.size(); ++h) {
    const std::uint32_t mate = mesh.mates().aligned[h];
    edges_[h].is_first = mate > h;
    if (mate != kNoHalfEdge && is_in_plane(mesh, h, mate, error_m) &&
        is_in_plane(mesh, mate, h, error_m)) {
      edges_[h].is_sharp = false;
      continue;
    }
    sharp_vertices_[faces[h / 3][h % 3]] = true;
    sharp_vertices_[faces[h / 3][next_half_edge(h) % 3]] = true;
  }
}

std::uint64_t MeshFeatures::bytes(const WeldedSurface& mesh) {
  const std::uint64_t faces = mesh.face_count();
  return OverlapTree::bytes(faces) +
         faces * (sizeof(Box) + 3 * (sizeof(std::uint32_t) + sizeof(Edge))) +
         mesh.positions().size() * (2 * sizeof(std::uint32_t) + 1);
}

}  // namespace palpate
