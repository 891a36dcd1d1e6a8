#pragma once

// Real-time scheduling of the calling thread.

#include <optional>
#include <string>

namespace palpate {

// Above ordinary threads and below the real-time threads of the kernel. The process that guards
// motors runs one above.
inline constexpr int kHapticPriority = 80;

// The result of starting a haptic thread: whether the device started, and what the operating system
// granted.
struct RealtimeStatus {
  std::string device_problem;  // why the device did not start; no thread runs. Empty: started
  bool fifo_priority = false;  // SCHED_FIFO
  bool locked_memory = false;  // no page that was touched can be swapped out
  bool fixed_cpu = false;      // the thread stays on the CPU that was asked for
  std::string explanation;     // one line: refused requests and remedies; empty if none was refused
};

// Gives the calling thread the priority kHapticPriority under SCHED_FIFO, pins it to a CPU if one
// is given, locks the memory of the process as it is touched (MCL_ONFAULT), and touches and locks
// the part of the stack that a tick can use. Never fails: the status states what was refused.
RealtimeStatus make_realtime(std::optional<int> cpu);

// Unlocks the memory of the process.
void unlock_memory();

}  // namespace palpate
