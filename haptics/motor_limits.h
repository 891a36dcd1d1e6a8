#pragma once

// The forces that a device's motors can push.

#include <array>
#include <limits>
#include <span>

#include "geometry/base/types.h"
#include "palpate/device.h"

namespace palpate {

// A scaled force must not exceed its limit by rounding. Its length rounds in three products, two
// sums, a root, a quotient and the scaling, each of them by half an epsilon at most.
inline constexpr double kBelowLimit = 1.0 - 8 * std::numeric_limits<double>::epsilon();

// The span of the motors' directions, and the force of each motor that adds up to a given force.
//
// Thread-safety: immutable. No function allocates or throws, so that a device whose motors turn can
// create one in every tick.
class MotorLimits {
 public:
  // At most three motors, each with a finite direction; the first three are used. A motor whose
  // direction depends linearly on those before it gets no share of a force. A peak force of 0 is
  // unknown, and no limit.
  explicit MotorLimits(std::span<const MotorDescription> motors) noexcept;

  // The part of a force in the span of the motors, device frame. Equals the force to the bit if
  // the force lies in the span, up to rounding.
  Vec3 part(const Vec3& force_N) const noexcept;

  // The largest factor, at most 1, by which a force in the span may be multiplied so that no motor
  // exceeds its peak force.
  double scale(const Vec3& force_N) const noexcept;

  // The force of each motor that adds up to a force in the span, divided by the motor's continuous
  // force, in the order of the motors given. 0 where the continuous force is unknown, and for a
  // motor without a share.
  Vec3 loads(const Vec3& force_N) const noexcept;

 private:
  void find_rows() noexcept;

  int count_ = 0;
  std::array<Vec3, 3> basis_;  // orthonormal, by Gram and Schmidt
  std::array<double, 3> peak_N_{};
  std::array<double, 3> continuous_N_{};
  std::array<int, 3> given_{};  // the index of each motor among those given
  std::array<Vec3, 3> rows_;    // a motor's share of a force in the span is rows_[i] . force
  // No motor can exceed half of its peak force under a force whose squared length is less than
  // this; the half is far more than rounding.
  double harmless_N2_ = std::numeric_limits<double>::infinity();
  Mat3 to_basis_ = Mat3::Identity();  // upper triangular: motor j is sum_i to_basis_(i, j) basis_i
};

}  // namespace palpate
