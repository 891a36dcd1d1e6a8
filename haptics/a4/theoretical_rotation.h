#pragma once

// Action 5 of A4: the theoretical rotation, which would align the contact normal with the actuated
// axes.

#include "haptics/a4/actuation.h"

namespace palpate {

// Table 1 as printed has three faults (Lecuyer et al. 2005):
//   Case 1: axis -A3 and angle acos(N.A1) give the right direction only while N.A2 >= 0; in the
//           other half-plane the scene turns the long way round.
//   Case 2: acos(N.A1) always aligns with +A1, by up to 180 deg, although an actuator pushes in
//           both directions and Figure 3 ends at 90 deg.
//   Case 3: the angle acos((N.A1)^2 + (N.A2)^2) lacks a square root, so it is up to 1.41 times the
//           true angle.
// kCorrected corrects all three; kAsPrinted keeps them, for comparison.
enum class Table1Form : std::uint8_t { kCorrected, kAsPrinted };

// The end of a single motor's line to which the normal turns. The corrected form turns to the
// nearer end, by up to 90 deg, where Figure 3 ends. Table 1's acos(N.A1) reads as a turn to +A1, by
// up to 180 deg, which is kForward. With several actuators, the two are the same.
enum class Alignment : std::uint8_t { kNearest, kForward };

// A rotation of the scene in the device frame: unit axis, angle from 0 to pi plus the hysteresis,
// rad. Angle 0 means no rotation.
struct AxisAngle {
  Vec3 axis_device = Vec3::UnitZ();
  double angle_rad = 0.0;
};

// Computes Table 1. Remembers the direction with which A4 is aligning the normal. Without this
// memory, a normal between two equally near directions would make the scene tremble.
//
// The corrected form is the same for all cases. T is the direction of the projection of N on the
// actuated span, or +-A1 with one actuator. The axis is N x T, and the angle is
// atan2(|N x T|, N.T).
//   One actuator: T = s A1. The sign s changes only if N.(s A1) < -sin(kHysteresis).
//   Two actuators: T keeps its value while |projection| < sin(kHysteresis).
//   New contact: s = +1 unless N.A1 < -sin(kHysteresis); T = A1 if |projection| < sin(kHysteresis).
//   One actuator and kForward: T = A1. Near -A1, two ways round are equally long. While N is at
//   most kHysteresis from -A1, the scene turns on in the direction in which it turned; a new
//   contact there turns about +A3, or about another fixed axis if the motor pushes along A3. The
//   angle is therefore at most pi + kHysteresis. With 3 sensors, N may go round -A1 there; the axis
//   N x A1 then goes with it, on the side of the last axis.
//
// Thread-safety: one thread owns an object.
class TheoreticalRotation {
 public:
  static constexpr double kHysteresisDeg = 2.0;

  // alignment: counts for the corrected form and one actuator.
  TheoreticalRotation(const ActuationModel& actuation, Table1Form form,
                      Alignment alignment = Alignment::kNearest)
      : actuation_(actuation), form_(form), alignment_(alignment) {}

  // Returns the theoretical rotation; its angle is 0 if no axis or all sensed axes are actuated.
  // normal_device: the contact normal, unit, or zero if there is none; with 2 sensors it must lie
  // in the sensed plane. No allocation.
  AxisAngle update(const Vec3& normal_device) noexcept;

  // Sets the axes of motors that turn with the device, for the next update(). The remembered
  // direction T is kept as far as the new axes allow. With one actuator, T keeps its side; with two
  // actuators, T becomes its projection on the span of the new axes. An equal model changes
  // nothing.
  void set_actuation(const ActuationModel& actuation) noexcept;

  // Ends the contact: the next normal chooses T without memory.
  void reset() noexcept { has_target_ = false; }

 private:
  AxisAngle corrected(const Vec3& normal_device) noexcept;
  AxisAngle forward(const Vec3& normal_device) noexcept;
  AxisAngle as_printed(const Vec3& normal_device) const noexcept;

  ActuationModel actuation_;
  Table1Form form_;
  Alignment alignment_;
  bool has_target_ = false;
  Vec3 target_device_ = Vec3::UnitX();  // T
  Vec3 axis_device_ = Vec3::UnitZ();    // of the last turn; for kForward
};

}  // namespace palpate
