#pragma once

// Runs a session at a fixed rate on its own thread.

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "engine/session/haptic_session.h"

namespace palpate {

struct HapticThreadSettings {
  double rate_Hz = 1000.0;      // at least 1: a tick is at most kLongestTick_s long
  std::uint64_t max_ticks = 0;  // 0: until stop()
};

// The result of starting a haptic thread: whether the device started, and the real-time scheduling
// granted by the operating system.
struct RealtimeStatus {
  std::string device_problem;  // why the device did not start; no thread runs. Empty: started
  bool fifo_priority = false;  // SCHED_FIFO
  bool locked_memory = false;  // no page of the process can be swapped out
  std::string explanation;     // one line: refused requests and remedies; empty if none was refused
};

// The haptic thread. It wakes at the absolute times start + k / rate, so that a late tick does not
// delay the following ticks. It passes the nominal time step to the loop, so that equal inputs give
// equal outputs. A tick that ends after the next due time counts as one missed deadline; due times
// that have already passed are skipped.
//
// After start() returns, the thread does not allocate, lock or do I/O. Signals are blocked on this
// thread; other threads handle them. When the thread ends, it stops the session, whose last command
// is zero force.
class HapticThread {
 public:
  // The session must outlive the thread.
  HapticThread(HapticSession& session, const HapticThreadSettings& settings);
  ~HapticThread();  // calls stop()
  HapticThread(const HapticThread&) = delete;
  HapticThread& operator=(const HapticThread&) = delete;

  // Starts the session and the thread, and returns the real-time scheduling that the system
  // granted. Call this function once.
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

 private:
  void run();

  HapticSession& session_;
  HapticThreadSettings settings_;
  std::thread thread_;
  std::atomic<bool> begin_{false};
  std::atomic<bool> stop_{false};
  std::atomic<bool> running_{false};
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<std::uint64_t> missed_deadlines_{0};
  bool locked_memory_ = false;
};

}  // namespace palpate
