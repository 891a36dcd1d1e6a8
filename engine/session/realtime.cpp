#include "engine/session/realtime.h"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include "engine/devices/realtime_limit.h"

namespace palpate {
namespace {

// A choice, and not a measured need: the part of the thread's stack, 8 MB by default, that is ready
// for the frames of a tick, of the device and of observers. A deeper frame meets a page fault once.
constexpr std::size_t kStack_bytes = 256 * 1024;
constexpr std::size_t kPage_bytes = 4096;

// Touches the pages below the present stack pointer and locks them, so that no tick meets a page
// fault there.
[[gnu::noinline]] bool lock_stack() {
  volatile unsigned char stack[kStack_bytes];
  for (std::size_t i = 0; i < kStack_bytes; i += kPage_bytes) stack[i] = 0;
  return ::mlock(const_cast<unsigned char*>(stack), kStack_bytes) == 0;
}

void add(std::string& explanation, const std::string& sentence) {
  if (!explanation.empty()) explanation += "; ";
  explanation += sentence;
}

}  // namespace

RealtimeStatus make_realtime(std::optional<int> cpu) {
  RealtimeStatus status;
  const sched_param priority{kHapticPriority};
  const int refused = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  status.fifo_priority = refused == 0;
  if (refused != 0) {
    add(status.explanation, std::string("SCHED_FIFO was refused (") + std::strerror(refused) +
                                "), so ticks may be late: " + fifo_remedy() + ", or run as root");
  }
  if (cpu) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(*cpu), &only);
    const int unpinned = ::pthread_setaffinity_np(::pthread_self(), sizeof only, &only);
    status.fixed_cpu = unpinned == 0;
    if (unpinned != 0) {
      add(status.explanation, "CPU " + std::to_string(*cpu) + " was refused (" +
                                  std::strerror(unpinned) + "): give --cpu a CPU that exists");
    }
  }
  const bool locks = ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
  status.locked_memory = lock_stack() && locks;
  if (!status.locked_memory) {
    add(status.explanation,
        std::string("memory is not locked, so a page fault may delay a tick: write "
                    "`* - memlock unlimited` to ") +
            kLimitsFile + " and log in again, or run as root");
  }
  return status;
}

void unlock_memory() {
  ::munlockall();
}

}  // namespace palpate
