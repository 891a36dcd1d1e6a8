#pragma once

// The memory and the messages that an engine shares with the process that guards its motors
// (engine/guard). This header depends only on the standard library and on Linux.

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate {

inline constexpr std::uint32_t kGuardMagic = 0x44524750;  // "PGRD"
// Both sides compare it: a guard of another build refuses its work.
inline constexpr std::uint32_t kGuardVersion = 2;
inline constexpr int kGuardSocket = 3;  // the descriptor of the socket in the guard
// Above the haptic thread (haptic_thread.cpp), so that a busy haptic thread cannot delay the guard.
inline constexpr int kGuardPriority = 81;
inline constexpr std::int64_t kGuardWakeNs = 50'000'000;  // an armed guard wakes at least so often

// Two processes share these variables. Times are those of monotonic_ns(). A trip has a number, its
// epoch.
struct GuardMemory {
  std::uint32_t magic = kGuardMagic;
  std::uint32_t version = kGuardVersion;

  // The owner of the device writes this.
  alignas(64) std::atomic<std::uint32_t> is_armed{0};
  // How far CLOCK_BOOTTIME was ahead of CLOCK_MONOTONIC when the owner armed the guard, at most;
  // the guard raises it when the machine was suspended since.
  std::atomic<std::int64_t> boot_ahead_ns{0};

  // The driver's thread writes these.
  alignas(64) std::atomic<std::int64_t> beat_ns{0};  // when the last command was written
  std::atomic<std::int64_t> tick_ns{0};              // the time of the tick it came from
  std::atomic<std::int32_t> driver_thread{0};        // the thread that beats; 0: none has yet
  // The last trip that the driver has seen. The guard clears it when it needs a new look.
  std::atomic<std::uint64_t> seen_epoch{0};
  std::atomic<std::uint64_t> acknowledged_epoch{0};  // the device is set up again after this trip

  // The guard writes these.
  alignas(64) std::atomic<std::uint64_t> trip_epoch{0};  // the number of trips
  std::atomic<std::uint64_t> quiet_epoch{0};  // the guard writes no zeros any more after this trip
  // 1: the last trip was because the machine was suspended. The driver clears it with its
  // acknowledgement.
  std::atomic<std::uint32_t> was_suspended{0};
  std::atomic<std::int64_t> guard_ns{0};  // when the guard last woke
  std::atomic<std::int32_t> guard_pid{0};
  std::atomic<std::uint32_t> is_guard_alive{0};  // 0 before its first word and after its end

  static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "two processes share them");
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
  static_assert(std::atomic<std::int32_t>::is_always_lock_free);
};

// The first message to the guard. With it come three descriptors: the device, the memory and a
// pidfd of the engine, in this order.
struct GuardOrder {
  std::uint32_t magic = kGuardMagic;
  std::uint32_t version = kGuardVersion;
  std::int32_t engine_pid = 0;
  std::int64_t stale_ns = 0;                       // the age at which a heartbeat is stale, > 0
  std::uint32_t zero_count = 0;                    // > 0
  std::array<std::uint8_t, 4096> zero_bytes = {};  // bring the device to zero force, from any state
};

// The first word of the guard: it is ready, or it says why not.
struct GuardWord {
  std::uint32_t magic = kGuardMagic;
  std::uint32_t version = kGuardVersion;
  std::int32_t fifo_error = 0;         // an errno; 0: the guard runs with SCHED_FIFO
  std::int32_t lock_error = 0;         // an errno; 0: the guard's memory is locked
  std::array<char, 160> problem = {};  // one line; empty: ready
};

// The later messages, one byte each: the engine has written `is_armed`, and the guard has read it.
inline constexpr char kGuardBell = 'b';

}  // namespace palpate
