#pragma once

// Runs a session at a fixed rate on its own thread.

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <thread>

#include "engine/session/haptic_session.h"
#include "engine/session/realtime.h"
#include "engine/session/tick_times.h"

namespace palpate {

// The name of the thread in the system's tools.
inline constexpr const char* kHapticThreadName = "palpate-haptic";

struct HapticThreadSettings {
  double rate_Hz = 1000.0;      // at least 1: a tick is at most kLongestTick_s long
  std::uint64_t max_ticks = 0;  // 0: until stop()
  std::optional<int> cpu = {};  // the CPU on which the thread stays, >= 0
  // Receives the CPU times of the first ticks, ns; must outlive the thread.
  std::span<std::uint32_t> cpu_times_ns = {};
};

// The haptic thread. It wakes at the absolute times start + k / rate, so that a late tick does not
// delay the following ticks. It passes the nominal time step to the loop, so that equal inputs give
// equal outputs. A tick that ends after the next due time counts as one missed deadline; due times
// that have already passed are skipped.
//
// After start() returns, the thread does not allocate, lock or do I/O. It measures the times of
// every tick, which takes less than 1 us. Signals are blocked on this thread; other threads handle
// them. When the thread ends, it stops the session, whose last command is zero force.
class HapticThread {
 public:
  // The session must outlive the thread.
  HapticThread(HapticSession& session, const HapticThreadSettings& settings);
  ~HapticThread();  // calls stop()
  HapticThread(const HapticThread&) = delete;
  HapticThread& operator=(const HapticThread&) = delete;

  // Starts the session, then the thread, and returns what the system granted (make_realtime()).
  // The first tick begins after that. Call this function once.
  RealtimeStatus start();
  // Ends the thread after the current tick and waits for its end.
  void stop();
  // Waits until max_ticks ticks are done.
  void join();

  bool running() const { return running_.load(std::memory_order_acquire); }
  std::uint64_t ticks() const { return ticks_.load(std::memory_order_acquire); }
  std::uint64_t missed_deadlines() const {
    return missed_deadlines_.load(std::memory_order_acquire);
  }
  // Of all ticks. Call it after join() or stop().
  const TickTimes& times() const { return meter_.times(); }

 private:
  void run();
  // Returns whether the tick ended after next_due_ns.
  bool run_tick(std::int64_t due_ns, std::int64_t next_due_ns, double dt_s);

  HapticSession& session_;
  HapticThreadSettings settings_;
  std::thread thread_;
  std::atomic<bool> begin_{false};
  std::atomic<bool> stop_{false};
  std::atomic<bool> running_{false};
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<std::uint64_t> missed_deadlines_{0};
  RealtimeStatus status_;  // set by the thread before is_ready_
  std::atomic<bool> is_ready_{false};
  TickMeter meter_;
};

}  // namespace palpate
