#pragma once

// What a driver's thread asks the process that guards its motors.

#include <cstdint>

namespace palpate {

enum class GuardState : std::uint8_t {
  kAlive,
  kEnded,  // the process is gone
  kFrozen  // the process exists and does not run: stopped by a signal, or never scheduled
};

// The guard stops the motors when the driver's thread stops writing (motor_guard.h). No function
// blocks, allocates or throws.
class WriteGuard {
 public:
  virtual ~WriteGuard() = default;
  // Called after a command was written. tick_ns: the time of the tick that the command came from;
  // now_ns: the present time. Both are on the monotonic clock, which the caller has just read.
  virtual void beat(std::int64_t tick_ns, std::int64_t now_ns) noexcept = 0;
  // Increases when the guard has stopped the motors. The driver compares it before each write, and
  // writes zero force from then on.
  virtual std::uint64_t trip_epoch() const noexcept = 0;
  // The driver has set up the device again after the guard's trip of this epoch.
  virtual void acknowledge(std::uint64_t epoch) noexcept = 0;
  // False while the guard still writes zeros after a trip, which would undo a set-up of the device.
  // After the driver has compared trip_epoch() with the epoch it knew, it writes zero force and
  // waits until this is true; then it sets up the device and acknowledges.
  virtual bool is_quiet() const noexcept { return true; }
  // Whether the last trip was because the machine was suspended. False after acknowledge().
  virtual bool was_suspended() const noexcept { return false; }
  // now_ns: as in beat().
  virtual GuardState state(std::int64_t now_ns) const noexcept = 0;
  // False: nobody stops the motors any more.
  bool is_alive(std::int64_t now_ns) const noexcept { return state(now_ns) == GuardState::kAlive; }
};

}  // namespace palpate
