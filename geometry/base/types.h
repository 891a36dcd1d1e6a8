#pragma once

// Vectors and rigid transforms shared by every folder. SI units throughout.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

// Unaligned, so that the layout of a struct that contains a Quat does not depend on the -m flags of
// the translation unit that includes this header.
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

using Triangle = std::array<std::uint32_t, 3>;  // vertex indices, counter-clockwise from the front

// u . (v x w). The formula is written out, because Eigen computes the cross product through memory:
// scalar stores, then a vector load that waits for them.
inline double triple_product(const Vec3& u, const Vec3& v, const Vec3& w) {
  return u.x() * (v.y() * w.z() - v.z() * w.y()) + u.y() * (v.z() * w.x() - v.x() * w.z()) +
         u.z() * (v.x() * w.y() - v.y() * w.x());
}

// A rigid transform named T_to_from: p_to = rotation * p_from + translation_m.
struct RigidTransform {
  Quat rotation = Quat::Identity();   // unit quaternion, from -> to
  Vec3 translation_m = Vec3::Zero();  // origin of "from" in "to", metres

  Vec3 point(const Vec3& p_from) const { return rotation * p_from + translation_m; }
  Vec3 direction(const Vec3& v_from) const { return rotation * v_from; }
  Vec3 inverse_point(const Vec3& p_to) const {
    return rotation.conjugate() * Vec3(p_to - translation_m);
  }
  Vec3 inverse_direction(const Vec3& v_to) const { return rotation.conjugate() * v_to; }
};

// Largest accepted deviation of a rotation quaternion's squared length from 1: several times the
// rounding error of a unit quaternion in single precision.
inline constexpr double kUnitQuaternion = 32 * std::numeric_limits<float>::epsilon();

// Whether T is a rigid pose: finite, with a rotation quaternion of length 1 within single
// precision.
inline bool is_pose(const RigidTransform& T) noexcept {
  return std::abs(T.rotation.squaredNorm() - 1.0) <= kUnitQuaternion && T.translation_m.allFinite();
}

// The same pose, with its quaternion normalised to length 1 within the rounding of double.
inline RigidTransform unit_pose(const RigidTransform& T) noexcept {
  constexpr double kRounded = 4 * std::numeric_limits<double>::epsilon();
  if (std::abs(T.rotation.squaredNorm() - 1.0) <= kRounded) return T;
  return {T.rotation.normalized(), T.translation_m};
}

// Whether the direction has length 1 within 4 kUnitQuaternion. A unit axis can have this error
// after it has been rotated by the matrix of a quaternion that is_pose() accepts.
inline bool is_unit(const Vec3& direction) noexcept {
  return std::abs(direction.squaredNorm() - 1.0) <= 4 * kUnitQuaternion;
}

}  // namespace palpate
