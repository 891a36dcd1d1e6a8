#include "haptics/proxy/anisotropic_norm.h"

namespace palpate {

// In the stretched space z = S y, the half-space n.y >= d is (S^-1 n).z >= d. A plane of motion
// that contains the axes is the same plane there.
PlaneProjection AnisotropicNorm::project(std::span<const ContactPlane> planes, const Vec3& target,
                                         const MotionPlane* motion_plane) const noexcept {
  std::array<ContactPlane, kMaxContactPlanes> stretched;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Vec3 normal = mixed(planes[i].normal, 1.0 / stretch_);
    const double length = normal.norm();
    stretched[i] = {normal / length, planes[i].offset_m / length};
  }
  const auto all = std::span<const ContactPlane>(stretched).first(planes.size());
  const Vec3 stretched_target = mixed(target, stretch_);
  PlaneProjection nearest = motion_plane ? project_within(*motion_plane, all, stretched_target)
                                         : project_onto_planes(all, stretched_target);
  nearest.displacement_m = nearest.solved && nearest.active_count == 0
                               ? target
                               : mixed(nearest.displacement_m, 1.0 / stretch_);
  if (motion_plane && nearest.active_count > 0) {
    nearest.displacement_m = motion_plane->part_of(nearest.displacement_m);
  }
  return nearest;
}

bool AnisotropicNorm::is_within(const Vec3& motion_plane_normal) const noexcept {
  constexpr double kRounded = 4 * kUnitQuaternion;
  for (std::size_t i = 0; i < count_; ++i) {
    if (std::abs(axes_[i].dot(motion_plane_normal)) > kRounded) return false;
  }
  return true;
}

}  // namespace palpate
