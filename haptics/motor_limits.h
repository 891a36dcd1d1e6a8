#pragma once

// The forces that a device's motors can push.

#include <array>
#include <cstddef>
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

  // False if no motor's load exceeds 1 under a force in the span. Faster than the loads.
  bool may_overload(const Vec3& force_N) const noexcept {
    return !are_below_half(continuous_N_, force_N);
  }

 private:
  // An orthonormal basis of the span, by Gram and Schmidt. It leaves out dependent motors.
  struct Basis {
    Basis() noexcept = default;
    Basis(const std::array<Vec3, 3>& directions, int count) noexcept;

    int count = 0;
    std::array<Vec3, 3> axes;
    std::array<std::size_t, 3> motors{};  // the motor of each axis
    // Upper triangular: the direction of motors[j] is sum_i of_motors(i, j) axes[i].
    Mat3 of_motors = Mat3::Identity();
  };

  void find_rows() noexcept;
  bool are_below_half(const std::array<double, 3>& limits_N, const Vec3& force_N) const noexcept;
  double scale(const Vec3& force_N, const Basis& basis) const noexcept;

  std::array<Vec3, 3> directions_;  // unit vectors
  std::array<double, 3> peak_N_{};
  std::array<double, 3> continuous_N_{};
  // A motor's share of a force in the span is rows_[i] . force.
  std::array<Vec3, 3> rows_ = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<double, 3> row2_{};  // the squared length of each row
  // Whether there are three motors that are clearly independent. Their basis is computed when it is
  // needed, because its three steps wait for each other.
  bool spans_all_ = false;
  Basis basis_;
};

}  // namespace palpate
