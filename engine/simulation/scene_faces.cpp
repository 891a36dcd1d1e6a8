#include "engine/simulation/scene_faces.h"

#include <algorithm>

namespace palpate {

SceneFace SceneFaceReader::read(std::uint32_t object, std::uint32_t face) const {
  const SceneObject& o = scene_.objects()[object];
  const OpenMeshSurface& surface = scene_.mesh(o.mesh).surface();
  const AffineMap deformation = scene_.deformation(object);
  SceneFace read;
  read.object = object;
  read.face = face;
  auto h = surface.halfedge_handle(OpenMesh::FaceHandle(static_cast<int>(face)));
  for (std::size_t k = 0; k < 3; ++k) {
    read.edges[k] = h;
    read.corners_m[k] =
        o.T_scene_body.point(deformation(surface.point(surface.from_vertex_handle(h))));
    h = surface.next_halfedge_handle(h);
  }
  const Vec3 cross =
      (read.corners_m[1] - read.corners_m[0]).cross(read.corners_m[2] - read.corners_m[0]);
  read.winding = cross.stableNormalized();
  if (!read.winding.allFinite()) read.winding = Vec3::Zero();
  const bool is_mirrored = deformation.linear.determinant() < 0.0;
  read.normal = is_mirrored ? Vec3(-read.winding) : read.winding;
  return read;
}

std::optional<SceneFace> SceneFaceReader::across(const SceneFace& face, std::size_t k) const {
  const OpenMeshSurface& surface = scene_.mesh(scene_.objects()[face.object].mesh).surface();
  const auto next = surface.opposite_face_handle(face.edges[k]);
  if (!next.is_valid()) return std::nullopt;
  const SceneFace found = read(face.object, static_cast<std::uint32_t>(next.idx()));
  if (found.winding.isZero(0.0)) return std::nullopt;
  return found;
}

SceneFaceSampler::SceneFaceSampler(const Scene& scene, UniformRandom& random)
    : faces_(scene), random_(random) {
  std::size_t count = 0;
  for (const SceneObject& object : scene.objects()) {
    first_of_object_.push_back(count);
    count += scene.mesh(object.mesh).face_count();
  }
  step_ = count / kMostWeighed + 1;
  double area = 0.0;
  std::uint32_t object = 0;
  for (std::size_t n = static_cast<std::size_t>(random.uniform() * static_cast<double>(step_));
       n < count; n += step_) {
    while (object + 1 < first_of_object_.size() && first_of_object_[object + 1] <= n) ++object;
    const SceneFace face =
        faces_.read(object, static_cast<std::uint32_t>(n - first_of_object_[object]));
    const auto& c = face.corners_m;
    area += (c[1] - c[0]).cross(c[2] - c[0]).norm();
    if (area_up_to_.empty()) first_ = n;
    area_up_to_.push_back(area);
  }
}

SceneFace SceneFaceSampler::draw() {
  const double at = random_.uniform() * area_up_to_.back();
  const auto found = std::upper_bound(area_up_to_.begin(), area_up_to_.end(), at);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(found - area_up_to_.begin()),
                                       area_up_to_.size() - 1);
  const std::size_t n = first_ + i * step_;
  const auto after = std::upper_bound(first_of_object_.begin(), first_of_object_.end(), n);
  const auto object = static_cast<std::uint32_t>(after - first_of_object_.begin() - 1);
  return faces_.read(object, static_cast<std::uint32_t>(n - first_of_object_[object]));
}

}  // namespace palpate
