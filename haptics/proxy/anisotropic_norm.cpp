#include "haptics/proxy/anisotropic_norm.h"

namespace palpate {

// In the stretched space z = S y, the half-space n.y >= d is (S^-1 n).z >= d.
PlaneProjection AnisotropicNorm::project(std::span<const ContactPlane> planes,
                                         const Vec3& target) const noexcept {
  std::array<ContactPlane, kMaxContactPlanes> stretched;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Vec3 normal = mixed(planes[i].normal, 1.0 / stretch_);
    const double length = normal.norm();
    stretched[i] = {normal / length, planes[i].offset_m / length};
  }
  PlaneProjection nearest =
      project_onto_planes(std::span(stretched).first(planes.size()), mixed(target, stretch_));
  nearest.displacement_m = nearest.solved && nearest.active_count == 0
                               ? target
                               : mixed(nearest.displacement_m, 1.0 / stretch_);
  return nearest;
}

}  // namespace palpate
