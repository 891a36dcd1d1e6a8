#include "engine/viewer/live_settings.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/session/run_setting.h"
#include "haptics/check_settings.h"

namespace palpate {
LiveSettings::LiveSettings(const Scene& scene, const RunSetup& setup)
    : scene_(&scene),
      checked_(setup.haptics),
      sensors_(setup.actuation.sensors()),
      motor_template_(setup.device.motors) {
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    wanted_.settings[i] = kLiveSettings[i].value(setup.haptics);
    most_[i] = std::max(kLiveSettings[i].most(), wanted_.settings[i]);
  }
  for (int i = 0; i < setup.actuation.actuators(); ++i) {
    const Vec3& axis = setup.actuation.actuated_axis(i);
    axes_.push_back(axis);
    wanted_.axes[wanted_.axis_count++] = {axis.x(), axis.y(), axis.z()};
  }
  taken_ = wanted_;
}

std::optional<Error> LiveSettings::check(std::size_t place, double value) const {
  const LiveSetting& setting = kLiveSettings[place];
  const std::string name(setting.name);
  if (setting.is_of_strategy && checked_.strategy) {
    return invalid_argument(name,
                            "belongs to the strategy " + name_of(*checked_.strategy) +
                                " of this session; expected no change",
                            "start the session with another --strategy");
  }
  const double least = setting.least();
  if (setting.can_be(value) && value >= least && value <= most_[place]) return std::nullopt;
  std::ostringstream text;
  text << "is " << value << "; expected a number from " << least << " to " << most_[place] << " "
       << setting.of_run().unit;
  return invalid_argument(name, text.str());
}

std::optional<Error> LiveSettings::set(std::size_t place, double value) {
  if (auto error = check(place, value)) return error;
  if (value == wanted_.settings[place]) return std::nullopt;
  HapticSettings settings = checked_;
  kLiveSettings[place].put(settings, value);
  if (auto error = check_settings(scene_->world(), settings)) return error;
  checked_ = settings;
  wanted_.settings[place] = value;
  publish();
  return std::nullopt;
}

std::optional<Error> LiveSettings::set_axes(const std::vector<Vec3>& axes_device) {
  const auto actuation = axes_device.empty() ? ActuationModel::from_counts(sensors_, 0)
                                             : ActuationModel::from_axes(sensors_, axes_device);
  if (!actuation) {
    Error error = actuation.error();
    error.element = "axes";
    return error;
  }
  if (axes_device == axes_) return std::nullopt;
  axes_ = axes_device;
  ++wanted_.axes_number;
  wanted_.axis_count = axes_device.size();
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
  const bool had_all = has_all_motors();
  const std::uint64_t last_axes = taken_.axes_number;
  if (!mailbox_.read(taken_)) return;
  is_new_ = true;
  if (taken_.axes_number == last_axes && has_all_motors() == had_all) return;
  has_new_motors_ = true;
  find_motors();
}

// Under ForceMode::kFull, every sensed axis has a motor, as in a hand session of `run`.
bool LiveSettings::has_all_motors() const noexcept {
  return taken_.settings[live_setting("force")] == static_cast<double>(ForceMode::kFull);
}

void LiveSettings::find_motors() noexcept {
  const bool has_all = has_all_motors();
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
  has_new_motors_ = false;
  apply(loop);
  applied_.store(taken_.number, std::memory_order_release);
}

void LiveSettings::apply(LoopChanges loop) noexcept {
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    const double now = kLiveSettings[i].value(loop.loop().settings());
    if (taken_.settings[i] != now) loop.set(i, taken_.settings[i]);
  }
  if (taken_.axes_number == applied_axes_number_) return;
  applied_axes_number_ = taken_.axes_number;
  std::array<Vec3, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = Vec3(taken_.axes[i].data());
  const auto actuation =
      ActuationModel::from_axes_at_pose(sensors_, std::span(axes).first(taken_.axis_count));
  if (actuation) loop.set_actuation(*actuation);
}

}  // namespace palpate
