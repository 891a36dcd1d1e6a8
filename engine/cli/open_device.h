#pragma once

// A device that a command opens before its session, because what it measures decides the settings.

#include <optional>

#include "engine/devices/guardable_device.h"
#include "geometry/base/result.h"

namespace palpate {

// The device, open from start() on. The destructor stops a device that no session has stopped, with
// zero force. One thread owns an object.
class OpenDevice {
 public:
  explicit OpenDevice(GuardableDevice& device) : device_(device) {}
  ~OpenDevice();
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

  // No force is commanded. The device knows its delay and its line from then on. Call it once.
  std::optional<Error> start();

 private:
  GuardableDevice& device_;
};

}  // namespace palpate
