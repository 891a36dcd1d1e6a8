#pragma once

// Conversions between the numbers of a TickRecord and vectors or poses, exact to the bit.

#include "haptics/a4/scene_pose.h"
#include "palpate/record.h"

namespace palpate {

inline Vec3 vec3(const double (&numbers)[3]) noexcept {
  return {numbers[0], numbers[1], numbers[2]};
}

inline void put(const Vec3& v, double (&numbers)[3]) noexcept {
  for (int k = 0; k < 3; ++k) numbers[k] = v[k];
}

// A vector that refers to the numbers without a copy: HapticLoop keeps its state in the record.
inline Eigen::Map<const Vec3> view(const double (&numbers)[3]) noexcept {
  return Eigen::Map<const Vec3>(numbers);
}
inline Eigen::Map<Vec3> view(double (&numbers)[3]) noexcept {
  return Eigen::Map<Vec3>(numbers);
}

// A pose is stored as a unit quaternion, w first, and an origin.
inline ScenePose scene_pose(const double (&q_wxyz)[4], const double (&o_m)[3]) noexcept {
  return {Quat(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]), vec3(o_m)};
}

inline void put(const ScenePose& pose, double (&q_wxyz)[4], double (&o_m)[3]) noexcept {
  const Quat& q = pose.rotation;
  q_wxyz[0] = q.w();
  q_wxyz[1] = q.x();
  q_wxyz[2] = q.y();
  q_wxyz[3] = q.z();
  put(pose.translation_m, o_m);
}

// T_device_scene before the elementary rotation of the tick, and after it.
inline ScenePose pose_before(const TickRecord& record) noexcept {
  return scene_pose(record.q_before_wxyz, record.o_before_m);
}
inline ScenePose pose_after(const TickRecord& record) noexcept {
  return scene_pose(record.q_after_wxyz, record.o_after_m);
}

}  // namespace palpate
