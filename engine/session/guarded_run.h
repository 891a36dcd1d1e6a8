#pragma once

// Starts and ends a session on a device with motors, in an order in which every step can fail
// without a force.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/guardable_device.h"
#include "engine/devices/motor_guard.h"
#include "engine/session/haptic_session.h"
#include "engine/session/haptic_thread.h"
#include "geometry/base/result.h"

namespace palpate {

struct GuardedRunSettings {
  HapticThreadSettings thread;
  // False: nothing stops the motors if this process hangs or ends. For tests. The device must work
  // without a guard as well.
  bool has_guard = true;
  // True: a device that keeps its last force is started also where SCHED_FIFO is refused. Its
  // session may then trip on a busy machine.
  bool without_realtime = false;
};

// The haptic thread of a session, and the process that guards the motors of its device. One thread,
// the owner, calls all functions.
class GuardedRun {
 public:
  // session: of this device, not started. Both must outlive this object.
  GuardedRun(GuardableDevice& device, HapticSession& session, const GuardedRunSettings& settings);
  ~GuardedRun();  // calls stop()
  GuardedRun(const GuardedRun&) = delete;
  GuardedRun& operator=(const GuardedRun&) = delete;

  // Opens the device, which commands zero without a guard; refuses rates of ticks and messages
  // below LeastRates for a device that pushes; asks for real-time scheduling; starts and arms the
  // guard; starts the haptic thread, whose session begins with zero force (the rule *start* of the
  // governor). If a step fails, the steps before it are undone, and no force was commanded. Call
  // this function once.
  std::optional<Error> start();
  // The same in reverse order: the thread commands zero and stops the device; then the guard is
  // disarmed and ended. Does nothing if nothing runs.
  void stop();

  const HapticThread& thread() const { return thread_; }
  // Null without a guard, before start() and after stop().
  const MotorGuard* guard() const { return guard_.get(); }
  // After start(): whether the haptic thread and the guard have SCHED_FIFO.
  bool has_fifo() const { return has_fifo_; }
  // One line each: what is missing for a safe run in time, and how the guard ended.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::optional<Error> start_steps();
  std::optional<Error> open_device();
  std::optional<Error> check_rates();
  std::optional<Error> start_guard();
  std::optional<Error> start_thread();
  std::optional<Error> check_fifo(const std::string& refusal) const;
  void stop_guard();

  GuardableDevice& device_;
  HapticSession& session_;
  GuardedRunSettings settings_;
  std::unique_ptr<MotorGuard> guard_;
  HapticThread thread_;
  bool is_open_ = false;   // the device; this object must stop it
  bool is_armed_ = false;  // the guard
  bool has_fifo_ = false;
  std::vector<std::string> warnings_;
};

}  // namespace palpate
