#include "engine/trials/seen_picture.h"

#include <cmath>
#include <numbers>

namespace palpate {

double turn_since_rad(const ScenePose& T_first, const ScenePose& T_now) {
  const Quat turn = T_now.rotation * T_first.rotation.conjugate();
  double angle_rad = 2.0 * std::atan2(turn.z(), turn.w());  // in [-2 pi, 2 pi]
  if (angle_rad > std::numbers::pi) angle_rad -= 2.0 * std::numbers::pi;
  if (angle_rad <= -std::numbers::pi) angle_rad += 2.0 * std::numbers::pi;
  return angle_rad;
}

SeenPicture seen_picture(View view, const ScenePose& T_first, const ScenePose& T_now,
                         const Vec3& proxy_scene_m, const Vec3& device_scene_m) {
  return {view == View::kStill ? T_first : T_now, proxy_scene_m, device_scene_m};
}

bool has_turned(const ScenePose& T_first, const ScenePose& T_now) {
  return T_now.rotation.coeffs() != T_first.rotation.coeffs();
}

ScenePose adapted_pose(const ScenePose& T_first, const ScenePose& T_now, const Vec3& seen_scene_m,
                       const Vec3& felt_device_m, double share) {
  if (share == 1.0 || !has_turned(T_first, T_now)) return T_now;
  const Eigen::AngleAxisd turn(share * turn_since_rad(T_first, T_now), Vec3::UnitZ());
  const Quat rotation = (Quat(turn) * T_first.rotation).normalized();
  return {rotation, felt_device_m - rotation * seen_scene_m};
}

}  // namespace palpate
