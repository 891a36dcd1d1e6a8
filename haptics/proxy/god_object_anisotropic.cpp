// The god-object in an anisotropic norm: see GodObject::move_in_norm().

#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/proxy/god_object_escapes.h"

namespace palpate {
namespace {

// The policy of GodObject::move_in_norm(): no friction, and distances in the norm.
struct InNorm {
  static constexpr bool kHolds = false;

  const AnisotropicNorm* norm;

  static bool holds() { return false; }
  static bool may_hold_at(const FaceContact&, const Vec3&) { return false; }
  double length(const Vec3& v) const { return norm->length(v); }
  PlaneProjection project(std::span<const ContactPlane> planes, const Vec3& target) const {
    return norm->project(planes, target);
  }
  PlaneProjection project_within(const MotionPlane& motion_plane,
                                 std::span<const ContactPlane> planes, const Vec3& target) const {
    return norm->project(planes, target, &motion_plane);
  }
  Vec3 along(const Vec3& v, const Vec3& line) const { return norm->along(v, line); }
  Vec3 within(const Vec3& v, const Vec3& normal) const { return norm->within(v, normal); }
};

}  // namespace

ProxyState GodObject::move_in_norm(const Vec3& goal, const std::optional<Vec3>& motion_plane_normal,
                                   const AnisotropicNorm& norm) noexcept {
  if (settings_.radius_m > 0.0 || !is_goal(goal, motion_plane_normal)) return refused();
  if (motion_plane_normal && !norm.is_within(*motion_plane_normal)) return refused();
  rest_.forget_friction();
  InNorm in_norm{&norm};
  return move(goal, motion_plane_normal, in_norm);
}

}  // namespace palpate
