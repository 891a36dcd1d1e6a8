#pragma once

// The simulated device with motors that follow the page's settings, and which can be paused.

#include <atomic>
#include <optional>
#include <span>
#include <string>

#include "engine/simulation/simulated_device.h"
#include "engine/viewer/live_settings.h"

namespace palpate {

// Any thread may call set_paused().
class HeldDevice final : public Device {
 public:
  // Both must outlive this object.
  HeldDevice(SimulatedDevice& device, LiveSettings& settings)
      : device_(device), settings_(settings) {}

  // While paused, the device and the hand keep their state and their time stands still.
  void set_paused(bool paused) noexcept { is_paused_.store(paused, std::memory_order_relaxed); }

  const DeviceDescription& description() const noexcept override { return device_.description(); }
  DeviceSample read(double dt_s) noexcept override {
    settings_.take();
    if (!is_paused_.load(std::memory_order_relaxed)) sample_ = device_.read(dt_s);
    return sample_;
  }
  void command(const DeviceCommand& command) noexcept override { device_.command(command); }
  std::span<const MotorDescription> motors_now() const noexcept override {
    return settings_.motors();
  }

 private:
  SimulatedDevice& device_;
  LiveSettings& settings_;
  DeviceSample sample_;
  std::atomic<bool> is_paused_{false};
};

}  // namespace palpate
