#include "haptics/a4/actuation.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>

namespace palpate {
namespace {

// A unit direction lies in a span if its part outside the span is at most this: the bound covers
// the rounding of the direction itself and of two Gram-Schmidt passes.
constexpr double kSpanRoundoff = 64 * std::numeric_limits<double>::epsilon();

std::string describe(std::size_t i, const Vec3& axis) {
  std::ostringstream text;
  text << "actuated axis " << i + 1 << " (" << axis.x() << " " << axis.y() << " " << axis.z()
       << ")";
  return text.str();
}

std::optional<Error> check_sensors(int sensors) {
  if (sensors == 2 || sensors == 3) return std::nullopt;
  if (sensors == 1) {
    return invalid_argument("sensors",
                            "is 1, which leaves no axis to rotate about; expected 2 or 3",
                            "Table 1 of the paper begins with 2 sensors");
  }
  return invalid_argument("sensors", "is " + std::to_string(sensors) + "; expected 2 or 3",
                          "count position axes only: a 6-DOF device senses a point with 3");
}

// The problem of one axis. axis: its index.
struct BadAxis {
  enum class Problem : std::uint8_t { kNoDirection, kLeavesPlane, kTooMany, kDependent };
  std::size_t axis;
  Problem problem;
};

Error error_of(const BadAxis& bad, const Vec3& axis) {
  const std::string name = describe(bad.axis, axis);
  switch (bad.problem) {
    case BadAxis::Problem::kNoDirection:
      return invalid_argument(name,
                              "has no direction; expected a finite vector of non-zero length");
    case BadAxis::Problem::kLeavesPlane:
      return invalid_argument(
          name, "leaves the plane of the sensed axes; expected a vector in the plane A1 A2",
          "set its third component to 0, or use 3 sensors");
    case BadAxis::Problem::kTooMany:
      return invalid_argument(name,
                              "exceeds the number of sensors; expected at most one axis per sensor",
                              "leave it out, or use more sensors");
    case BadAxis::Problem::kDependent:
      break;
  }
  return invalid_argument(name, "depends linearly on the axes before it; expected independent axes",
                          "leave it out: the other axes already span its direction");
}

// Gram-Schmidt in two passes: the second removes the rounding of the first. Missing axes are filled
// up with the device's axes.
std::optional<BadAxis> orthonormal_basis(int sensors, std::span<const Vec3> axes_device,
                                         std::array<Vec3, 3>& basis) noexcept {
  basis = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  for (std::size_t i = 0; i < axes_device.size(); ++i) {
    const Vec3& axis = axes_device[i];
    const double largest = axis.cwiseAbs().maxCoeff();
    if (!axis.allFinite() || largest == 0.0) return BadAxis{i, BadAxis::Problem::kNoDirection};
    Vec3 direction = (axis / largest).normalized();  // scaled first: no overflow
    if (sensors == 2 && std::abs(direction.z()) > kSpanRoundoff) {
      return BadAxis{i, BadAxis::Problem::kLeavesPlane};
    }
    if (i >= static_cast<std::size_t>(sensors)) return BadAxis{i, BadAxis::Problem::kTooMany};
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t j = 0; j < i; ++j) direction -= direction.dot(basis[j]) * basis[j];
    }
    if (direction.norm() <= kSpanRoundoff) return BadAxis{i, BadAxis::Problem::kDependent};
    basis[i] = direction.normalized();
  }
  return std::nullopt;
}

}  // namespace

Result<ActuationModel> ActuationModel::from_counts(int sensors, int actuators) {
  if (const auto error = check_sensors(sensors)) return *error;
  if (actuators < 0) {
    return invalid_argument("actuators",
                            "is " + std::to_string(actuators) + "; expected 0 or more");
  }
  if (actuators > sensors) {
    return invalid_argument("actuators",
                            "is " + std::to_string(actuators) + "; expected at most " +
                                std::to_string(sensors) + ", the number of sensors",
                            "an actuated axis must be sensed");
  }
  return ActuationModel(sensors, actuators, {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()});
}

Result<ActuationModel> ActuationModel::from_axes(int sensors,
                                                 const std::vector<Vec3>& axes_device) {
  if (const auto error = check_sensors(sensors)) return *error;
  std::array<Vec3, 3> basis;
  if (const auto bad = orthonormal_basis(sensors, axes_device, basis)) {
    return error_of(*bad, axes_device[bad->axis]);
  }
  return ActuationModel(sensors, static_cast<int>(axes_device.size()), basis);
}

std::optional<ActuationModel> ActuationModel::from_axes_at_pose(
    int sensors, std::span<const Vec3> axes_device) noexcept {
  std::array<Vec3, 3> basis;
  const bool is_good =
      (sensors == 2 || sensors == 3) && !orthonormal_basis(sensors, axes_device, basis).has_value();
  if (!is_good) return std::nullopt;
  return ActuationModel(sensors, static_cast<int>(axes_device.size()), basis);
}

std::optional<ActuationModel> ActuationModel::from_basis(
    int sensors, int actuators, const std::array<Vec3, 3>& basis) noexcept {
  if ((sensors != 2 && sensors != 3) || actuators < 0 || actuators > sensors) return std::nullopt;
  for (std::size_t i = 0; i < basis.size(); ++i) {
    if (static_cast<int>(i) >= actuators) break;  // filled up with the device's axes
    if (!(std::abs(basis[i].squaredNorm() - 1.0) <= kSpanRoundoff)) return std::nullopt;
    for (std::size_t j = 0; j < i; ++j) {
      if (!(std::abs(basis[i].dot(basis[j])) <= kSpanRoundoff)) return std::nullopt;
    }
  }
  for (const Vec3& axis : basis) {
    if (!axis.allFinite()) return std::nullopt;
  }
  return ActuationModel(sensors, actuators, basis);
}

ActuationCase ActuationModel::table1_case() const {
  if (actuators_ == 0) return ActuationCase::kNoActuator;
  if (actuators_ == sensors_) return ActuationCase::kFullyActuated;
  if (sensors_ == 2) return ActuationCase::kCase1;
  return actuators_ == 1 ? ActuationCase::kCase2 : ActuationCase::kCase3;
}

Vec3 ActuationModel::actuated_part(const Vec3& v_device) const {
  if (actuators_ == 3) return v_device;
  Vec3 part = Vec3::Zero();
  for (int i = 0; i < actuators_; ++i) part += v_device.dot(actuated_axis(i)) * actuated_axis(i);
  return part;
}

double ActuationModel::angle_to_actuated_rad(const Vec3& unit_device) const {
  if (actuators_ == 3) return 0.0;
  if (actuators_ == 0) return std::numbers::pi / 2;
  const Vec3 part = actuated_part(unit_device);
  return std::atan2((unit_device - part).norm(), part.norm());
}

}  // namespace palpate
