#include "haptics/a4/theoretical_rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

const double kHysteresisSine =
    std::sin(TheoreticalRotation::kHysteresisDeg * std::numbers::pi / 180.0);

// The direction of N x A1 has lost half of its digits if its length is below this, the square root
// of the rounding of a unit vector.
constexpr double kLeastSine = 1e-8;

AxisAngle about(const Vec3& axis, double angle_rad) {
  const double length = axis.norm();
  if (length == 0.0) return {};
  return {axis / length, angle_rad};
}

// The axis about which a new contact turns whose normal is -a1: orthogonal to a1, and A3 unless the
// motor pushes along A3.
Vec3 axis_of_about_turn(const Vec3& a1) {
  const Vec3 across = Vec3::UnitZ() - a1.z() * a1;
  return across.norm() >= kHysteresisSine ? Vec3(across.normalized()) : a1.unitOrthogonal();
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
    if (alignment_ == Alignment::kNearest) return;
    const Vec3 across = axis_device_ - axis_device_.dot(a1) * a1;
    axis_device_ =
        across.norm() >= kHysteresisSine ? Vec3(across.normalized()) : axis_of_about_turn(a1);
    return;
  }
  const Vec3 part = actuation_.actuated_part(target_device_);
  target_device_ = part.norm() >= kHysteresisSine ? Vec3(part.normalized()) : a1;
}

AxisAngle TheoreticalRotation::corrected(const Vec3& normal_device) noexcept {
  const Vec3& a1 = actuation_.actuated_axis(0);
  if (actuation_.actuators() == 1) {
    if (alignment_ == Alignment::kForward) return forward(normal_device);
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

AxisAngle TheoreticalRotation::forward(const Vec3& normal_device) noexcept {
  const Vec3& a1 = actuation_.actuated_axis(0);
  if (!has_target_) axis_device_ = axis_of_about_turn(a1);
  has_target_ = true;
  const Vec3 w = normal_device.cross(a1);
  const double sine = w.norm();
  const double cosine = normal_device.dot(a1);
  if (sine == 0.0) return {axis_device_, cosine < 0.0 ? std::numbers::pi : 0.0};
  Vec3 axis = w / sine;
  double angle_rad = std::atan2(sine, cosine);
  const bool is_near_back = cosine < 0.0 && sine <= kHysteresisSine;
  if (is_near_back && axis.dot(axis_device_) < 0.0) {
    axis = -axis;
    angle_rad = 2.0 * std::numbers::pi - angle_rad;
  }
  if (!is_near_back || sine >= kLeastSine) axis_device_ = axis;
  return {axis, angle_rad};
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
