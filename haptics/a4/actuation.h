#pragma once

// The sensed and the actuated axes of a device.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// The rows of Table 1 (Lecuyer et al. 2005), and the two cases that the table leaves out.
enum class ActuationCase : std::uint8_t {
  kNoActuator,    // no axis to align with: no force, no rotation
  kCase1,         // 2 sensors, 1 actuator
  kCase2,         // 3 sensors, 1 actuator
  kCase3,         // 3 sensors, 2 actuators
  kFullyActuated  // every sensed axis is actuated: no rotation
};

// The sensed and actuated axes of one device. Device frame: axes A1 = x, A2 = y, A3 = z, unit
// vectors. With N sensors, the first N axes are sensed. M actuators push along the first M axes, or
// along any M linearly independent directions in the sensed span, orthogonal or not.
//
// Thread-safety: immutable, so queries are safe on any thread, including the haptic thread.
class ActuationModel {
 public:
  // The first `actuators` axes are actuated. Requires 2 or 3 sensors and 0 <= actuators <= sensors.
  // Otherwise returns an Error with the reason.
  static Result<ActuationModel> from_counts(int sensors, int actuators);

  // axes_device: the directions of the actuated axes, device frame. Each has a finite, non-zero
  // length and lies in the sensed span; together they are linearly independent. Otherwise returns
  // an Error.
  static Result<ActuationModel> from_axes(int sensors, const std::vector<Vec3>& axes_device);

  // Like from_axes(), but for motors that turn with the device. Safe in every tick on the haptic
  // thread, because it does not allocate. Returns nullopt where from_axes() returns an Error.
  static std::optional<ActuationModel> from_axes_at_pose(
      int sensors, std::span<const Vec3> axes_device) noexcept;

  // A model with the numbers of another one, as actuated_axis() returned them for i = 0, 1, 2, and
  // equal to it bit for bit. Returns nullopt unless the numbers are those of a model: 2 or 3
  // sensors, at most as many actuators, and actuated axes that are orthonormal. Does not allocate.
  static std::optional<ActuationModel> from_basis(int sensors, int actuators,
                                                  const std::array<Vec3, 3>& basis) noexcept;

  int sensors() const { return sensors_; }
  int actuators() const { return actuators_; }
  ActuationCase table1_case() const;
  bool is_planar() const { return sensors_ == 2; }

  // Vector i of an orthonormal basis of the actuated span, i < actuators(). Vector 0 has the
  // direction of the first actuated axis.
  const Vec3& actuated_axis(int i) const { return basis_[static_cast<std::size_t>(i)]; }

  // Orthogonal projection onto the actuated span: the part of a force that the actuators can
  // produce.
  Vec3 actuated_part(const Vec3& v_device) const;

  // Contact angle: the angle between a unit vector and the actuated line, plane or space, in [0,
  // pi/2] rad. Without actuators it is pi/2.
  double angle_to_actuated_rad(const Vec3& unit_device) const;

  // True if all numbers are equal bit for bit.
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
