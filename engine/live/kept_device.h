#pragma once

// A board that stays open from one session to the next.

#include <span>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"

namespace palpate {

// A board counts from the pose in which it was opened: if each trial opened it again, the person
// would have to hold it in that pose each time. stop() commands zero and takes the guard away,
// without which the device commands zero; the destructor stops the device. One thread at a time
// uses an object, as of any device.
class KeptDevice final : public GuardableDevice {
 public:
  explicit KeptDevice(GuardableDevice& device) : device_(device) {}
  ~KeptDevice() override {
    device_.command({});
    device_.stop();
  }
  KeptDevice(const KeptDevice&) = delete;
  KeptDevice& operator=(const KeptDevice&) = delete;

  const DeviceDescription& description() const noexcept override { return device_.description(); }
  std::optional<std::string> start() override { return device_.start(); }
  DeviceSample read(double dt_s) noexcept override { return device_.read(dt_s); }
  void command(const DeviceCommand& command) noexcept override { device_.command(command); }
  std::span<const MotorDescription> motors_now() const noexcept override {
    return device_.motors_now();
  }
  void stop() noexcept override {
    device_.command({});
    device_.set_guard(nullptr);
  }
  DeviceHealth health() const override { return device_.health(); }
  int descriptor() const noexcept override { return device_.descriptor(); }
  std::vector<std::uint8_t> zero_bytes() const override { return device_.zero_bytes(); }
  void set_guard(WriteGuard* guard) noexcept override { device_.set_guard(guard); }
  LineRate line_rate() const override { return device_.line_rate(); }
  std::string summary() const override { return device_.summary(); }

 private:
  GuardableDevice& device_;
};

}  // namespace palpate
