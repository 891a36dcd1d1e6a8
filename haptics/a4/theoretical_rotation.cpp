#include "haptics/a4/theoretical_rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

const double kHysteresisSine =
    std::sin(TheoreticalRotation::kHysteresisDeg * std::numbers::pi / 180.0);

AxisAngle about(const Vec3& axis, double angle_rad) {
  const double length = axis.norm();
  if (length == 0.0) return {};
  return {axis / length, angle_rad};
}

double acos_of_dot(double cosine) {
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

}  // namespace

AxisAngle TheoreticalRotation::update(const Vec3& normal_device) noexcept {
  const ActuationCase row = actuation_.table1_case();
  if (row == ActuationCase::kNoActuator || row == ActuationCase::kFullyActuated) return {};
  if (normal_device.isZero(0.0)) return {};
  return form_ == Table1Form::kCorrected ? corrected(normal_device) : as_printed(normal_device);
}

void TheoreticalRotation::set_actuation(const ActuationModel& actuation) noexcept {
  if (actuation == actuation_) return;
  actuation_ = actuation;
  if (!has_target_ || actuation_.actuators() == 0) return;
  const Vec3& a1 = actuation_.actuated_axis(0);
  if (actuation_.actuators() == 1) {
    target_device_ = target_device_.dot(a1) < 0.0 ? Vec3(-a1) : a1;
    return;
  }
  const Vec3 part = actuation_.actuated_part(target_device_);
  target_device_ = part.norm() >= kHysteresisSine ? Vec3(part.normalized()) : a1;
}

AxisAngle TheoreticalRotation::corrected(const Vec3& normal_device) noexcept {
  const Vec3& a1 = actuation_.actuated_axis(0);
  if (actuation_.actuators() == 1) {
    if (!has_target_) target_device_ = a1;
    if (normal_device.dot(target_device_) < -kHysteresisSine) target_device_ = -target_device_;
  } else {
    const Vec3 part = actuation_.actuated_part(normal_device);
    if (part.norm() >= kHysteresisSine) {
      target_device_ = part.normalized();
    } else if (!has_target_) {
      target_device_ = a1;
    }
  }
  has_target_ = true;
  const Vec3 w = normal_device.cross(target_device_);
  return about(w, std::atan2(w.norm(), normal_device.dot(target_device_)));
}

AxisAngle TheoreticalRotation::as_printed(const Vec3& normal_device) const noexcept {
  const Vec3& a1 = actuation_.actuated_axis(0);
  const double n1 = normal_device.dot(a1);
  switch (actuation_.table1_case()) {
    case ActuationCase::kCase1:
      return about(-Vec3::UnitZ(), acos_of_dot(n1));
    case ActuationCase::kCase2:
      return about(normal_device.cross(a1), acos_of_dot(n1));
    case ActuationCase::kCase3: {
      const Vec3& a2 = actuation_.actuated_axis(1);
      const double n2 = normal_device.dot(a2);
      return about(n1 * normal_device.cross(a1) + n2 * normal_device.cross(a2),
                   acos_of_dot(n1 * n1 + n2 * n2));
    }
    default:
      return {};
  }
}

}  // namespace palpate
