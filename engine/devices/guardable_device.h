#pragma once

// A device whose motors a separate process can stop (motor_guard.h).

#include <cstdint>
#include <string>
#include <vector>

#include "engine/devices/line_rate.h"
#include "engine/devices/write_guard.h"
#include "palpate/device.h"

namespace palpate {

// The thread that owns the device calls these functions, between start() and stop() unless a
// comment says otherwise. GuardedRun starts the device before the session does, and a program may
// start it earlier: start() of a device that is open, and stop() of one that is not, move nothing.
class GuardableDevice : public Device {
 public:
  // The open device, with O_NONBLOCK. The guard gets a duplicate. -1 before start() and after
  // stop().
  virtual int descriptor() const noexcept = 0;
  // Bring the device to zero force from any state of its parser.
  virtual std::vector<std::uint8_t> zero_bytes() const = 0;
  // guard: must exist until stop() or until another call of this function has returned; null: none.
  // Without a guard the device commands zero, unless its settings say otherwise.
  virtual void set_guard(WriteGuard* guard) noexcept = 0;
  // Of this session or, after stop(), the last one.
  virtual LineRate line_rate() const { return {}; }
  // One line about the conversation with the device, also after stop().
  virtual std::string summary() const = 0;
};

}  // namespace palpate
