#pragma once

// Action 5 of A4: the rotation that would align the contact normal with the actuated axes.

#include "haptics/a4/actuation.h"

namespace palpate {

// Table 1 as printed has three faults (Lecuyer et al. 2005):
//   Case 1: axis -A3 and angle acos(N.A1) turn the right way only while N.A2 >= 0; for the other
//           half-plane the scene turns the long way round.
//   Case 2: acos(N.A1) always aligns with +A1, up to 180 deg, though an actuator pushes both ways
//           and Figure 3 ends at 90 deg.
//   Case 3: the angle acos((N.A1)^2 + (N.A2)^2) lacks a square root, so it is up to 1.41 times the
//           true angle.
// kCorrected mends all three; kAsPrinted keeps them, for comparison.
enum class Table1Form : std::uint8_t { kCorrected, kAsPrinted };

// A rotation of the scene in the device frame: unit axis, angle in [0, pi] rad. No rotation: 0.
struct AxisAngle {
  Vec3 axis_device = Vec3::UnitZ();
  double angle_rad = 0.0;
};

// Computes Table 1 and remembers what the normal is being aligned with, so that a normal that is
// undecided between two directions does not make the scene shiver.
//
// Corrected form, one for all cases: T is the direction of the projection of N on the actuated
// span, or +-A1 with one actuator; axis N x T, angle atan2(|N x T|, N.T).
//   One actuator: T = s A1. s changes only when N.(s A1) < -sin(kHysteresis).
//   Two actuators: where |projection| < sin(kHysteresis), T stays what it was.
//   A new contact starts afresh: s = +1 unless N.A1 < -sin(kHysteresis); T = A1 where undecided.
class TheoreticalRotation {
 public:
  static constexpr double kHysteresisDeg = 2.0;

  TheoreticalRotation(const ActuationModel& actuation, Table1Form form)
      : actuation_(actuation), form_(form) {}

  // normal_device: the contact normal, unit, or zero for none. With 2 sensors it lies in the sensed
  // plane. noexcept, no allocation.
  AxisAngle update(const Vec3& normal_device) noexcept;

  // Motors that turn with the device: from the next update() on. What the normal was being aligned
  // with goes on as far as the new axes can: with one actuator on the same side, with two along the
  // part of it that lies in their span. The same model changes nothing.
  void set_actuation(const ActuationModel& actuation) noexcept;

  // Contact was lost: the next normal chooses its direction afresh.
  void reset() noexcept { has_target_ = false; }

 private:
  AxisAngle corrected(const Vec3& normal_device) noexcept;
  AxisAngle as_printed(const Vec3& normal_device) const noexcept;

  ActuationModel actuation_;
  Table1Form form_;
  bool has_target_ = false;
  Vec3 target_device_ = Vec3::UnitX();  // T
};

}  // namespace palpate
