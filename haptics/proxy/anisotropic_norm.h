#pragma once

// A norm that weighs the parts of a lag along and across the motors differently.

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "geometry/base/types.h"
#include "haptics/proxy/plane_projection.h"

namespace palpate {

// The norm |v|_W = sqrt(v'W v) with W = I + (E - 1)(I - P), where P is the orthogonal projection on
// the span of some axes. With S = I + (sqrt(E) - 1)(I - P), |v|_W = |S v|: the norm of W is the
// Euclidean norm of a space that is stretched by sqrt(E) across the axes.
//
// Safe on the haptic thread: no allocation, lock or exception. Thread-safety: a value.
class AnisotropicNorm {
 public:
  // anisotropy: E, > 0. axes: at most three orthonormal directions, solver frame.
  AnisotropicNorm(double anisotropy, std::span<const Vec3> axes)
      : anisotropy_(anisotropy), stretch_(std::sqrt(anisotropy)), count_(axes.size()) {
    for (std::size_t i = 0; i < count_; ++i) axes_[i] = axes[i];
  }

  bool is_euclidean() const { return anisotropy_ == 1.0; }

  double length(const Vec3& v) const { return mixed(v, stretch_).norm(); }

  // The displacement to the point nearest to the target, in this norm, among those that satisfy
  // every plane: see project_onto_planes(), or project_within() for a plane of motion, in which the
  // axes must lie.
  PlaneProjection project(std::span<const ContactPlane> planes, const Vec3& target,
                          const MotionPlane* motion_plane = nullptr) const noexcept;
  // Whether the axes lie in the plane of motion with this unit normal, to within the rounding of
  // unit vectors (is_unit).
  bool is_within(const Vec3& motion_plane_normal) const noexcept;
  // The point of a line through 0 that is nearest to v, in this norm. line: its unit direction.
  Vec3 along(const Vec3& v, const Vec3& line) const {
    const Vec3 weighted = mixed(line, anisotropy_);
    return v.dot(weighted) / line.dot(weighted) * line;
  }
  // The point of a plane through 0 that is nearest to v, in this norm. normal: of the plane, unit.
  Vec3 within(const Vec3& v, const Vec3& normal) const {
    const Vec3 steepest = mixed(normal, 1.0 / anisotropy_);
    return v - v.dot(normal) / steepest.dot(normal) * steepest;
  }

 private:
  // The part of v along the axes, plus `across` times the rest.
  Vec3 mixed(const Vec3& v, double across) const {
    Vec3 part = Vec3::Zero();
    for (std::size_t i = 0; i < count_; ++i) part += v.dot(axes_[i]) * axes_[i];
    return part + across * (v - part);
  }

  double anisotropy_;
  double stretch_;
  std::size_t count_;
  std::array<Vec3, 3> axes_;
};

}  // namespace palpate
