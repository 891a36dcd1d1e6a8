#pragma once

// Runs a session at a fixed rate on a thread of its own.

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "engine/session/haptic_session.h"

namespace palpate {

struct HapticThreadSettings {
  double rate_Hz = 1000.0;      // at least 1: a longer tick than kLongestTick_s is none
  std::uint64_t max_ticks = 0;  // 0: until stop()
};

// How a thread has started, and what the operating system granted.
struct RealtimeStatus {
  std::string device_problem;  // why the device did not start, and no thread runs; empty if it did
  bool fifo_priority = false;  // SCHED_FIFO
  bool locked_memory = false;  // no page of the process can be swapped out
  std::string explanation;     // one line: what was refused and what to do; empty if nothing was
};

// The haptic thread. It wakes at absolute times start + k / rate, so that a late tick does not
// delay those after it, and gives the loop the nominal dt, so that one input gives one output. A
// tick that ends after the next one is due is a missed deadline; due times that have passed by then
// are left out, not caught up.
//
// After start() returns the thread neither allocates nor locks nor does I/O. Signals to the process
// never interrupt it: other threads take them. When it ends, for whatever reason, it stops the
// session, whose last command is zero force.
class HapticThread {
 public:
  // The session must outlive the thread.
  HapticThread(HapticSession& session, const HapticThreadSettings& settings);
  ~HapticThread();  // stops
  HapticThread(const HapticThread&) = delete;
  HapticThread& operator=(const HapticThread&) = delete;

  // Starts the session and the thread, once; says what real-time scheduling the system granted.
  RealtimeStatus start();
  // Ends the loop after the present tick and waits for it.
  void stop();
  // Waits until max_ticks are done.
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
