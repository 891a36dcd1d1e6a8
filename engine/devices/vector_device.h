#pragma once

// Base class of simulated devices: two functions exchange position and force as vectors.

#include <cstdint>
#include <utility>

#include "geometry/base/types.h"
#include "palpate/device.h"

namespace palpate {

class VectorDevice : public Device {
 public:
  // By default a device that moves no motors.
  explicit VectorDevice(DeviceDescription description = without_motors())
      : description_(std::move(description)) {}

  // Position in the device frame, metres. dt_s: nominal time since the previous call.
  virtual Vec3 read_position_m(double dt_s) noexcept = 0;
  // Force on the hand in the device frame, newtons, held until the next call.
  virtual void command_force_N(const Vec3& force_device) noexcept = 0;

  const DeviceDescription& description() const noexcept final { return description_; }
  DeviceSample read(double dt_s) noexcept final {
    const Vec3 p = read_position_m(dt_s);
    DeviceSample sample;
    sample.position_m = {p.x(), p.y(), p.z()};
    sample.sequence = ++samples_;
    return sample;
  }
  void command(const DeviceCommand& command) noexcept final {
    command_force_N(Vec3(command.force_N.data()));
  }

 private:
  static DeviceDescription without_motors() {
    DeviceDescription description;
    description.moves_motors = false;
    return description;
  }

  DeviceDescription description_;
  std::uint64_t samples_ = 0;
};

}  // namespace palpate
