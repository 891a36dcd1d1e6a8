#include "engine/devices/hapi_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/devices/five_bar_workspace.h"

namespace palpate {
namespace {

constexpr const char* kHapiName = "pantograph on a hAPI board";

// The motors at a pose: torques = J^T . force, so that motor i alone exerts column i of the inverse
// of J^T. False if there is none.
bool find_motors(const Mat2& jacobian, double peak_torque_Nm, std::span<MotorDescription> motors) {
  const double det = jacobian.determinant();
  if (!std::isfinite(1.0 / det)) return false;
  Mat2 forces_per_Nm;
  forces_per_Nm << jacobian(1, 1), -jacobian(1, 0), -jacobian(0, 1), jacobian(0, 0);
  forces_per_Nm /= det;
  for (int k = 0; k < 2; ++k) {
    const Vec2 force = forces_per_Nm.col(k);
    const Vec2 direction = force.normalized();
    MotorDescription& motor = motors[static_cast<std::size_t>(k)];
    motor.direction_device = {direction.x(), direction.y(), 0.0};
    motor.peak_force_N = motor.continuous_force_N = peak_torque_Nm * force.norm();
  }
  return true;
}

// The largest length of a force that both motors exert together.
double largest_force_N(std::span<const MotorDescription> motors) {
  const Vec3 first = motors[0].peak_force_N * Vec3(motors[0].direction_device.data());
  const Vec3 second = motors[1].peak_force_N * Vec3(motors[1].direction_device.data());
  return std::max((first + second).norm(), (first - second).norm());
}

PlaneBox workspace_of(const HapiSettings& settings) {
  return full_force_workspace(FiveBar(settings.links)).value_or(PlaneBox{});
}

// A step of one encoder moves the tip by at most this.
double largest_step_m(const HapiWiring& wiring, const Mat2& jacobian) {
  const double step_rad = 2.0 * std::numbers::pi / static_cast<double>(wiring.counts_per_turn);
  return step_rad * std::max(jacobian.col(0).norm(), jacobian.col(1).norm());
}

}  // namespace

DeviceDescription hapi_description(const HapiSettings& settings) {
  DeviceDescription device;
  device.name = kHapiName;
  device.sensed_axes = 2;
  device.rate_Hz = settings.rate_Hz;
  device.when_host_is_silent = HostSilence::kHoldsForce;
  const PlaneBox box = workspace_of(settings);
  const Vec2 half_m = 0.5 * (box.high_m - box.low_m);
  device.workspace_low_m = {-half_m.x(), -half_m.y(), 0.0};
  device.workspace_high_m = {half_m.x(), half_m.y(), 0.0};
  const auto rest = hapi_pose(FiveBar(settings.links), settings.wiring.rest_deg);
  if (!rest) return device;
  device.encoder_quantum_m = largest_step_m(settings.wiring, rest->jacobian);
  if (settings.torque_per_Nm &&
      find_motors(rest->jacobian, settings.peak_torque_Nm, device.motors)) {
    device.motor_count = kHapiJoints;
    device.peak_force_N =
        largest_force_N(std::span<const MotorDescription>(device.motors).first(kHapiJoints));
  }
  return device;
}

HapiView::HapiView(const HapiSettings& settings)
    : description_(hapi_description(settings)), peak_torque_Nm_(settings.peak_torque_Nm) {
  const PlaneBox box = workspace_of(settings);
  origin_m_ = 0.5 * (box.low_m + box.high_m);
  std::copy_n(description_.motors.begin(), kHapiJoints, motors_.begin());
}

DeviceSample HapiView::take(const HapiSample& sample) noexcept {
  DeviceSample taken;
  taken.position_m = {sample.tip_m[0] - origin_m_.x(), sample.tip_m[1] - origin_m_.y(), 0.0};
  taken.sequence = sample.sequence;
  taken.time_ns = sample.time_ns;
  taken.is_valid = sample.sequence > 0;
  taken.asks_for_trip = !sample.is_working || sample.trips != seen_trips_;
  seen_trips_ = sample.trips;
  turn_motors(sample);
  return taken;
}

void HapiView::turn_motors(const HapiSample& sample) noexcept {
  const auto& j = sample.jacobian;
  Mat2 jacobian;
  jacobian << j[0], j[1], j[2], j[3];
  find_motors(jacobian, peak_torque_Nm_, motors_);
}

std::span<const MotorDescription> HapiView::motors() const noexcept {
  return std::span(motors_).first(static_cast<std::size_t>(description_.motor_count));
}

}  // namespace palpate
