#pragma once

// A device that follows a recorded path, one position per tick, and ignores forces.

#include <span>

#include "geometry/base/types.h"
#include "palpate/device.h"

namespace palpate {

class PathDevice final : public Device {
 public:
  // path_m: device frame, metres; must outlive the device. Samples beyond the end of the path are
  // invalid.
  explicit PathDevice(std::span<const Vec3> path_m) : path_m_(path_m) {
    description_.name = "recorded path";
    description_.moves_motors = false;
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
