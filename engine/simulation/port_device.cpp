#include "engine/simulation/port_device.h"

#include <algorithm>
#include <cmath>

#include "engine/devices/light_device.h"

namespace palpate {

DeviceDescription motor_device(int motors, double peak_force_N, double rate_Hz) {
  DeviceDescription device;
  device.name = "simulated port";
  device.sensed_axes = std::max(2, motors);
  device.motor_count = motors;
  for (std::size_t i = 0; i < static_cast<std::size_t>(motors); ++i) {
    device.motors[i].direction_device = {};
    device.motors[i].direction_device[i] = 1.0;
    device.motors[i].peak_force_N = peak_force_N;
    device.motors[i].continuous_force_N = peak_force_N;
  }
  device.moves_motors = true;
  device.peak_force_N = peak_force_N;
  set_workspace_extent(device, 0.4);
  device.rate_Hz = rate_Hz;
  device.when_host_is_silent = HostSilence::kHoldsForce;
  return device;
}

PortDevice::PortDevice(const PortDeviceSettings& settings)
    : settings_(settings), tip_(settings.tip, settings.start_m) {}

DeviceSample PortDevice::read(double dt_s) noexcept {
  if (was_read_) advance_to(time_s_ + dt_s);
  const bool is_first = !was_read_;
  was_read_ = true;
  const bool is_due = is_first || ++ticks_since_sample_ >= settings_.ticks_per_sample;
  if (!is_due || (!is_first && no_samples_.contains(time_s_))) return sample_;
  ticks_since_sample_ = 0;
  const double quantum_m = settings_.device.encoder_quantum_m;
  for (std::size_t k = 0; k < 3; ++k) {
    const double x_m = tip_.position_m()[static_cast<Eigen::Index>(k)];
    sample_.position_m[k] = quantum_m > 0.0 ? quantum_m * std::round(x_m / quantum_m) : x_m;
  }
  ++sample_.sequence;
  return sample_;
}

void PortDevice::command(const DeviceCommand& command) noexcept {
  if (no_commands_.contains(time_s_)) return;
  if (count_ == on_the_way_.size()) {
    ++lost_commands_;
    return;
  }
  double acts_s = time_s_ + settings_.delay_s;
  if (count_ > 0) {
    acts_s = std::max(acts_s, on_the_way_[(first_ + count_ - 1) % on_the_way_.size()].acts_s);
  }
  Vec3 force_N(command.force_N.data());
  if (settings_.device.sensed_axes == 2) force_N.z() = 0.0;
  on_the_way_[(first_ + count_) % on_the_way_.size()] = {acts_s, force_N};
  ++count_;
}

void PortDevice::advance_to(double time_s) noexcept {
  while (count_ > 0 && on_the_way_[first_].acts_s <= time_s) {
    const Command& next = on_the_way_[first_];
    if (next.acts_s > time_s_) {
      tip_.advance(motors_N_, next.acts_s - time_s_);
      time_s_ = next.acts_s;
    }
    motors_N_ = next.force_N;
    first_ = (first_ + 1) % on_the_way_.size();
    --count_;
  }
  if (time_s > time_s_) tip_.advance(motors_N_, time_s - time_s_);
  time_s_ = time_s;
}

}  // namespace palpate
