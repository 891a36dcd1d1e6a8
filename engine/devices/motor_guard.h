#pragma once

// Starts the process that guards the motors of a device (engine/guard) and reports to it.

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <thread>
#include <vector>

#include "engine/devices/guard_memory.h"
#include "engine/devices/monotonic_clock.h"
#include "engine/devices/write_guard.h"
#include "geometry/base/result.h"

namespace palpate {

struct GuardSpec {
  int descriptor = -1;      // the open device, with O_NONBLOCK; the guard gets a duplicate
  double period_s = 0.001;  // nominal time between two commands, > 0
  // Bring the device to zero force from any state of its parser; at most 4,096 bytes.
  std::vector<std::uint8_t> zero_bytes;
};

// A heartbeat of this age makes the guard trip: 20 ms or 10 periods, the larger, ns.
std::int64_t stale_heartbeat_ns(double period_s) noexcept;

// The guard process. While armed, it stops the motors if the engine or the thread of the last
// beat() ends in any way, or if the last beat() or its tick is older than stale_heartbeat_ns(). A
// stale heartbeat is a trip: the guard writes zeros until the driver has seen the new trip_epoch();
// so is a suspended machine, which was_suspended() tells.
// When is_quiet() is true again, the driver sets up the device and calls acknowledge().
//
// Thread-safety: one thread, the owner, calls spawn(), arm(), disarm() and the destructor, which
// block; a guard that is frozen keeps none of them waiting for more than half a second. The
// functions of WriteGuard are for the driver's thread; they are wait-free and need no system call,
// except for the first beat() of a thread.
class MotorGuard final : public WriteGuard {
 public:
  // Starts the guard and waits for its first word. The program `palpate-guard` must lie in the
  // folder of the running program, or the environment variable PALPATE_GUARD must name it.
  static Result<std::unique_ptr<MotorGuard>> spawn(const GuardSpec& spec);
  // An armed guard stops the motors, as if the engine had ended. Waits until the guard has ended.
  ~MotorGuard() override;
  MotorGuard(const MotorGuard&) = delete;
  MotorGuard& operator=(const MotorGuard&) = delete;

  // After success the guard watches the heartbeat; no force may be written before. The driver calls
  // beat() from then on.
  // boot_ahead_ns: see guard_memory.h.
  std::optional<Error> arm(std::int64_t boot_ahead_ns = most_boot_ahead_ns());
  // Before this call, the driver has written zero force and has stopped writing.
  std::optional<Error> disarm();

  void beat(std::int64_t tick_ns, std::int64_t now_ns) noexcept override;
  void beat(std::int64_t tick_ns) noexcept { beat(tick_ns, monotonic_ns()); }
  // The driver looks at the epoch before each write, so this call also tells the guard that the
  // driver has seen the epoch.
  std::uint64_t trip_epoch() const noexcept override;
  void acknowledge(std::uint64_t epoch) noexcept override;
  bool was_suspended() const noexcept override;
  GuardState state(std::int64_t now_ns) const noexcept override;
  using WriteGuard::is_alive;
  bool is_alive() const noexcept { return is_alive(monotonic_ns()); }
  bool is_quiet() const noexcept override;

  // Whether the guard runs with SCHED_FIFO. If not, the guard may be late on a busy machine.
  bool has_fifo() const noexcept { return fifo_problem_.empty(); }
  // One line: why SCHED_FIFO was refused and how to permit it. Empty if has_fifo().
  const std::string& fifo_problem() const noexcept { return fifo_problem_; }
  pid_t process() const noexcept { return process_; }

 private:
  MotorGuard() = default;
  std::optional<Error> set_up(const GuardSpec& spec);
  std::optional<Error> start_process(const std::string& program, int socket);
  std::optional<Error> receive_word();
  std::optional<Error> ring();
  bool receive(void* content, std::size_t size) const;
  bool is_stopped() const noexcept;
  bool cannot_run() const noexcept;
  void wait_for_end() noexcept;

  GuardMemory* shared_ = nullptr;
  int memory_ = -1;  // the descriptor of *shared_
  int socket_ = -1;  // this side of the socket
  int pidfd_ = -1;   // of the guard
  pid_t process_ = -1;
  std::string fifo_problem_;
  std::atomic<bool> has_ended_{false};
  std::thread reaper_;
};

}  // namespace palpate
