#pragma once

// What a device senses and what it can push.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// The rows of Table 1 (Lecuyer et al. 2005), and the two ends it leaves out.
enum class ActuationCase : std::uint8_t {
  kNoActuator,    // nothing to align with: no force, no rotation
  kCase1,         // 2 sensors, 1 actuator
  kCase2,         // 3 sensors, 1 actuator
  kCase3,         // 3 sensors, 2 actuators
  kFullyActuated  // every sensed axis pushes: no rotation
};

// Device frame: axes A1 = x, A2 = y, A3 = z, unit vectors. Of N sensors the first N axes are
// sensed; the actuators push along the first M axes, or along any independent directions within the
// sensed span, orthogonal or not. Immutable; queries are safe on the haptic thread.
class ActuationModel {
 public:
  // sensors 2 or 3, 0 <= actuators <= sensors; anything else is an error that says why.
  static Result<ActuationModel> from_counts(int sensors, int actuators);

  // axes_device: any length but zero; linearly independent; within the sensed axes.
  static Result<ActuationModel> from_axes(int sensors, const std::vector<Vec3>& axes_device);

  // The same for the haptic thread, as motors that turn with the device need it each tick: nothing
  // where from_axes() has an error. No allocation.
  static std::optional<ActuationModel> from_axes_at_pose(
      int sensors, std::span<const Vec3> axes_device) noexcept;

  int sensors() const { return sensors_; }
  int actuators() const { return actuators_; }
  ActuationCase table1_case() const;
  bool is_planar() const { return sensors_ == 2; }

  // Orthonormal basis of the actuated span, i < actuators(). The first vector is the direction of
  // the first axis.
  const Vec3& actuated_axis(int i) const { return basis_[static_cast<std::size_t>(i)]; }

  // Orthogonal projection on the actuated span: what the actuators can give of a force.
  Vec3 actuated_part(const Vec3& v_device) const;

  // Angle between a unit vector and the actuated line, plane or space, in [0, pi/2] rad; pi/2
  // without actuators.
  double angle_to_actuated_rad(const Vec3& unit_device) const;

  // To the bit.
  bool operator==(const ActuationModel& other) const {
    return sensors_ == other.sensors_ && actuators_ == other.actuators_ && basis_ == other.basis_;
  }

 private:
  ActuationModel(int sensors, int actuators, const std::array<Vec3, 3>& basis)
      : sensors_(sensors), actuators_(actuators), basis_(basis) {}

  int sensors_;
  int actuators_;
  std::array<Vec3, 3> basis_;
};

}  // namespace palpate
