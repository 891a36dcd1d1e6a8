#pragma once

// The pose of the scene in the device frame, its rotation by A4, and its display.

#include "geometry/base/types.h"
#include "haptics/a4/theoretical_rotation.h"

namespace palpate {

// T_device_scene: p_device = R(q) p_scene + o.
using ScenePose = RigidTransform;

// Turns the scene about the pivot, a point that stays in place in both frames to within 2 ulp. The
// new origin o' is the solution of c = R(q') pivot + o', where c is the pivot in the device frame.
// The pivot therefore keeps its place, regardless of the rounding of q'. The quaternion is
// renormalised, so that its length stays within 4 ulp of 1 after any number of ticks.
inline ScenePose turned_about(const ScenePose& T_device_scene, const Vec3& pivot_scene_m,
                              const Vec3& pivot_device_m, const AxisAngle& turn) noexcept {
  const Quat step(Eigen::AngleAxisd(turn.angle_rad, turn.axis_device));
  ScenePose turned;
  turned.rotation = (step * T_device_scene.rotation).normalized();
  turned.translation_m = pivot_device_m - turned.rotation * pivot_scene_m;
  return turned;
}

// The same for a pivot whose place in the device frame follows from the pose.
inline ScenePose turned_about(const ScenePose& T_device_scene, const Vec3& pivot_scene_m,
                              const AxisAngle& turn) noexcept {
  return turned_about(T_device_scene, pivot_scene_m, T_device_scene.point(pivot_scene_m), turn);
}

// The frame that the display shows. Classical: the device frame, in which the proxy moves. Camera
// metaphor (action 2 of A4): the proxy stays at the display's centre and the scene moves instead,
// opposite to the user's motion (in the paper's symbols: To = 0, Ts = -Tu). The mode affects the
// display only; the haptic rendering is the same to the bit.
enum class DisplayMode : std::uint8_t { kClassical, kCamera };

inline RigidTransform display_transform(DisplayMode mode, const ScenePose& T_device_scene,
                                        const Vec3& proxy_scene_m) noexcept {
  RigidTransform T_display_scene = T_device_scene;
  if (mode == DisplayMode::kCamera) {
    T_display_scene.translation_m = -(T_device_scene.rotation * proxy_scene_m);
  }
  return T_display_scene;
}

}  // namespace palpate
