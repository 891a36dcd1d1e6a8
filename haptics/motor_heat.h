#pragma once

// The heat of a device's motors, which limits how long they may exert more than their continuous
// force.

#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

struct MotorHeatLimits {
  // A motor warms as the square of its force, and cools, with this time constant.
  static constexpr std::int64_t kTimeConstant_ns = 10'000'000'000;
  // A motor keeps its force up to this share of its continuous force, root mean square. From there
  // to the continuous force, what exceeds the continuous force is taken away by and by: a person
  // who presses on does not fall in. 2 % is what the limit may waste of a motor.
  static constexpr double kFadeFrom = 0.98;
};

// The mean square of the force of each motor, as a first-order low pass gives it, and the factor
// that keeps it at the square of the continuous force. A force is stated by its loads: the force of
// each motor, divided by the continuous force of that motor at the present pose, so that the
// heat of a motor that turns follows its current and not its lever. A motor whose continuous force
// is unknown has the load 0 (MotorLimits::loads() gives both).
//
// Let w be the load of the warmest motor that wants more than its continuous force, m its mean
// square, and x = (1 - m) / (1 - kFadeFrom^2), within 0 and 1. The motor gets the load l, with
// l^2 = 1 + (w^2 - 1) x. So m approaches 1 from below without a jump, and a load whose mean square
// never reaches kFadeFrom^2 is never scaled, whatever its peaks. One step cannot carry m beyond 1
// while (w^2 - 1) times the warming of the step is below the width of the fade: at 250 Hz, w < 10.
// Motors begin cold.
//
// Thread-safety: one thread owns an object. No function allocates or throws. The results are the
// same bits on every machine: no function of the mathematical library is used.
class MotorHeat {
 public:
  // Before a force is exerted: the factor, at most 1, for the whole force, so that its direction
  // stays. 1 exactly if no motor is too warm.
  double factor(const Vec3& loads) const noexcept;

  // After a force was exerted for a time: warms or cools each motor. Zero loads are a pause or a
  // trip. step_ns: >= 0. A load that is not finite counts as the continuous force.
  void add(const Vec3& loads, std::int64_t step_ns) noexcept;

  // The mean square of each motor's load.
  const Vec3& mean_squares() const noexcept { return mean_square_; }

 private:
  Vec3 mean_square_ = Vec3::Zero();
};

// 1 - exp(-time / kTimeConstant_ns), to rounding.
double warming_share(std::int64_t step_ns) noexcept;

}  // namespace palpate
