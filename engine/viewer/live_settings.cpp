#include "engine/viewer/live_settings.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptics/check_settings.h"

namespace palpate {
namespace {

std::optional<Error> check_range(const char* name, double value, double most, const char* unit) {
  if (value >= 0.0 && value <= most) return std::nullopt;  // false for NaN
  std::ostringstream text;
  text << "is " << value << "; expected a number from 0 to " << most << " " << unit;
  return invalid_argument(name, text.str());
}

}  // namespace

LiveSettings::LiveSettings(const Scene& scene, const RunSetup& setup)
    : scene_(&scene),
      checked_(setup.haptics),
      sensors_(setup.actuation.sensors()),
      most_stiffness_N_per_m_(
          std::max(kMostStiffness_N_per_m, setup.haptics.coupling.stiffness_N_per_m)),
      most_damping_Ns_per_m_(
          std::max(kMostDamping_Ns_per_m, setup.haptics.coupling.damping_Ns_per_m)),
      motor_template_(setup.device.motors) {
  wanted_.stiffness_N_per_m = setup.haptics.coupling.stiffness_N_per_m;
  wanted_.damping_Ns_per_m = setup.haptics.coupling.damping_Ns_per_m;
  wanted_.a4 = setup.haptics.a4.enabled ? 1 : 0;
  wanted_.force = static_cast<std::uint32_t>(setup.haptics.force);
  for (int i = 0; i < setup.actuation.actuators(); ++i) {
    const Vec3& axis = setup.actuation.actuated_axis(i);
    axes_.push_back(axis);
    wanted_.axes[wanted_.axis_count++] = {axis.x(), axis.y(), axis.z()};
  }
  taken_ = wanted_;
}

std::optional<Error> LiveSettings::check_strategy(const char* name) const {
  if (!checked_.strategy) return std::nullopt;
  return invalid_argument(name,
                          "belongs to the strategy " + name_of(*checked_.strategy) +
                              " of this session; expected no change",
                          "start the session with another --strategy");
}

std::optional<Error> LiveSettings::set_a4(bool enabled) {
  if (auto error = check_strategy("a4")) return error;
  wanted_.a4 = enabled ? 1 : 0;
  publish();
  return std::nullopt;
}

std::optional<Error> LiveSettings::set_force(ForceMode force) {
  if (auto error = check_strategy("force")) return error;
  wanted_.force = static_cast<std::uint32_t>(force);
  publish();
  return std::nullopt;
}

std::optional<Error> LiveSettings::set_stiffness(double stiffness_N_per_m) {
  if (auto error = check_range("stiffness", stiffness_N_per_m, most_stiffness_N_per_m_, "N/m")) {
    return error;
  }
  Values values = wanted_;
  values.stiffness_N_per_m = stiffness_N_per_m;
  if (auto error = check_coupling(values)) return error;
  wanted_ = values;
  publish();
  return std::nullopt;
}

std::optional<Error> LiveSettings::set_damping(double damping_Ns_per_m) {
  if (auto error = check_range("damping", damping_Ns_per_m, most_damping_Ns_per_m_, "N s/m")) {
    return error;
  }
  Values values = wanted_;
  values.damping_Ns_per_m = damping_Ns_per_m;
  if (auto error = check_coupling(values)) return error;
  wanted_ = values;
  publish();
  return std::nullopt;
}

std::optional<Error> LiveSettings::check_coupling(const Values& values) const {
  HapticSettings settings = checked_;
  settings.coupling.stiffness_N_per_m = values.stiffness_N_per_m;
  settings.coupling.damping_Ns_per_m = values.damping_Ns_per_m;
  return check_settings(scene_->world(), settings);
}

std::optional<Error> LiveSettings::set_axes(const std::vector<Vec3>& axes_device) {
  const auto actuation = axes_device.empty() ? ActuationModel::from_counts(sensors_, 0)
                                             : ActuationModel::from_axes(sensors_, axes_device);
  if (!actuation) {
    Error error = actuation.error();
    error.element = "axes";
    return error;
  }
  axes_ = axes_device;
  wanted_.has_axes = 1;
  wanted_.axis_count = static_cast<std::uint32_t>(axes_device.size());
  for (std::size_t i = 0; i < axes_device.size(); ++i) {
    const Vec3 unit = axes_device[i].normalized();
    wanted_.axes[i] = {unit.x(), unit.y(), unit.z()};
  }
  publish();
  return std::nullopt;
}

void LiveSettings::publish() {
  ++wanted_.number;
  mailbox_.publish(wanted_);
  newest_.store(wanted_.number, std::memory_order_release);
}

void LiveSettings::take() noexcept {
  is_taken_ = true;
  if (newest_.load(std::memory_order_acquire) == taken_.number) return;
  if (!mailbox_.read(taken_)) return;
  is_new_ = true;
  find_motors();
}

// Under ForceMode::kFull, every sensed axis has a motor, as in a hand session of `run`.
void LiveSettings::find_motors() noexcept {
  const bool has_all = static_cast<ForceMode>(taken_.force) == ForceMode::kFull;
  motors_ = motor_template_;
  motor_count_ = has_all ? static_cast<std::size_t>(sensors_) : 0;
  for (std::size_t i = 0; i < motor_count_; ++i) {
    motors_[i].direction_device = {0.0, 0.0, 0.0};
    motors_[i].direction_device[i] = 1.0;
  }
  if (has_all) return;
  motor_count_ = taken_.axis_count;
  for (std::size_t i = 0; i < motor_count_; ++i) motors_[i].direction_device = taken_.axes[i];
}

void LiveSettings::before_tick(double /*time_s*/, LoopChanges loop) noexcept {
  if (!is_taken_) take();
  is_taken_ = false;
  if (!is_new_) return;
  is_new_ = false;
  apply(loop);
  applied_.store(taken_.number, std::memory_order_release);
}

void LiveSettings::apply(LoopChanges loop) const noexcept {
  loop.set_a4(taken_.a4 != 0);
  loop.set_force(static_cast<ForceMode>(taken_.force));
  loop.set_coupling(taken_.stiffness_N_per_m, taken_.damping_Ns_per_m);
  if (taken_.has_axes == 0) return;
  std::array<Vec3, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = Vec3(taken_.axes[i].data());
  const auto actuation =
      ActuationModel::from_axes_at_pose(sensors_, std::span(axes).first(taken_.axis_count));
  if (actuation) loop.set_actuation(*actuation);
}

}  // namespace palpate
