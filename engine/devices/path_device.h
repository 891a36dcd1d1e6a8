#pragma once

// A device that is where a path says, tick by tick, and gives way to no force.

#include <span>

#include "geometry/base/types.h"
#include "palpate/device.h"

namespace palpate {

class PathDevice final : public Device {
 public:
  // Device frame, metres. The path must outlive the device. What is read beyond its end is invalid.
  explicit PathDevice(std::span<const Vec3> path_m) : path_m_(path_m) {
    description_.name = "recorded path";
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double) noexcept override {
    DeviceSample sample;
    sample.is_valid = next_ < path_m_.size();
    if (!sample.is_valid) return sample;
    const Vec3& p = path_m_[next_++];
    sample.position_m = {p.x(), p.y(), p.z()};
    sample.sequence = next_;
    return sample;
  }
  void command(const DeviceCommand&) noexcept override {}

 private:
  std::span<const Vec3> path_m_;
  std::size_t next_ = 0;
  DeviceDescription description_;
};

}  // namespace palpate
