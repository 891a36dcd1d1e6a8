#pragma once

// How the haptic thread sees a pantograph on a hAPI board.

#include <array>
#include <cstdint>
#include <span>

#include "engine/devices/hapi_link.h"
#include "engine/devices/hapi_settings.h"
#include "palpate/device.h"

namespace palpate {

// Describes the device. Device frame: the axes of FiveBar; the origin is the middle of
// full_force_workspace(), which is the workspace. Without a calibration (torque_per_Nm) the device
// has no motors. The settings must be checked (check_hapi_settings()).
DeviceDescription hapi_description(const HapiSettings& settings);

// Converts the driver's samples. One thread owns an object. No function but the constructor
// allocates or throws.
class HapiView {
 public:
  explicit HapiView(const HapiSettings& settings);

  const DeviceDescription& description() const noexcept { return description_; }
  // The delay of the description; before the first sample of a session.
  void set_delay(const DelayInterval& delay) noexcept { description_.delay = delay; }
  // Trips so far do not count: a session begins.
  void forget_trips(const HapiSample& sample) noexcept { seen_trips_ = sample.trips; }
  // The sample of a tick. It asks for a trip while the motors do not obey, and once for each trip
  // of the link.
  DeviceSample take(const HapiSample& sample) noexcept;
  // The motors at the pose of the last sample; at a pose without a Jacobian those of the pose
  // before. Empty without a calibration.
  std::span<const MotorDescription> motors() const noexcept;

 private:
  void turn_motors(const HapiSample& sample) noexcept;

  DeviceDescription description_;
  Vec2 origin_m_;
  double peak_torque_Nm_;
  std::array<MotorDescription, kHapiJoints> motors_;
  std::uint64_t seen_trips_ = 0;
};

}  // namespace palpate
