#include "engine/session/haptic_thread.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#include <utility>

namespace palpate {
namespace {

// Above ordinary threads and below the real-time threads of the kernel.
constexpr int kFifoPriority = 80;
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

std::int64_t monotonic_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

void sleep_until(std::int64_t due_ns) {
  const timespec due{due_ns / kNanosecondsPerSecond, due_ns % kNanosecondsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
  }
}

// A thread created during the lifetime of this object has all signals blocked.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

HapticThread::HapticThread(HapticSession& session, const HapticThreadSettings& settings)
    : session_(session), settings_(settings) {}

HapticThread::~HapticThread() {
  stop();
}

RealtimeStatus HapticThread::start() {
  RealtimeStatus status;
  if (auto problem = session_.start()) {
    status.device_problem = std::move(*problem);
    return status;
  }
  running_.store(true, std::memory_order_release);
  {
    const BlockedSignals blocked;
    thread_ = std::thread([this] { run(); });
  }
  const sched_param priority{kFifoPriority};
  const int refused = pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  status.fifo_priority = refused == 0;
  status.locked_memory = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  locked_memory_ = status.locked_memory;
  if (!status.fifo_priority) {
    status.explanation = std::string("SCHED_FIFO was refused (") + std::strerror(refused) +
                         "): ticks may be late; allow it with `ulimit -r 80` or run as root";
  }
  if (!status.locked_memory) {
    if (!status.explanation.empty()) status.explanation += "; ";
    status.explanation +=
        "memory is not locked: a page fault may delay a tick; allow it with `ulimit -l unlimited`";
  }
  begin_.store(true, std::memory_order_release);
  begin_.notify_one();
  return status;
}

void HapticThread::run() {
  begin_.wait(false, std::memory_order_acquire);
  const double dt_s = 1.0 / settings_.rate_Hz;
  const double period_ns = static_cast<double>(kNanosecondsPerSecond) * dt_s;
  const std::int64_t start_ns = monotonic_ns();
  std::int64_t period = 0;
  for (std::uint64_t n = 0; settings_.max_ticks == 0 || n < settings_.max_ticks; ++n) {
    if (stop_.load(std::memory_order_acquire)) break;
    const auto due = [&](std::int64_t k) {
      return start_ns + std::llround(static_cast<double>(k) * period_ns);
    };
    sleep_until(due(period));
    const std::int64_t now_ns = monotonic_ns();
    session_.tick(dt_s, std::max<std::int64_t>(0, now_ns - due(period)), now_ns);
    ticks_.store(n + 1, std::memory_order_release);
    const std::int64_t now = monotonic_ns();
    ++period;
    if (now > due(period)) {
      missed_deadlines_.fetch_add(1, std::memory_order_acq_rel);
      period =
          static_cast<std::int64_t>(std::ceil(static_cast<double>(now - start_ns) / period_ns));
    }
  }
  session_.stop();
  running_.store(false, std::memory_order_release);
}

void HapticThread::join() {
  if (thread_.joinable()) thread_.join();
  if (locked_memory_) munlockall();
  locked_memory_ = false;
}

void HapticThread::stop() {
  stop_.store(true, std::memory_order_release);
  join();
}

}  // namespace palpate
