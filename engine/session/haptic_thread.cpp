#include "engine/session/haptic_thread.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <pthread.h>
#include <time.h>
#include <utility>

#include "engine/devices/monotonic_clock.h"

namespace palpate {
namespace {

void sleep_until(std::int64_t due_ns) {
  const timespec due{due_ns / kSecond_ns, due_ns % kSecond_ns};
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
  if (auto problem = session_.start()) {
    RealtimeStatus status;
    status.device_problem = std::move(*problem);
    return status;
  }
  running_.store(true, std::memory_order_release);
  {
    const BlockedSignals blocked;
    thread_ = std::thread([this] { run(); });
  }
  is_ready_.wait(false, std::memory_order_acquire);
  RealtimeStatus status = status_;
  begin_.store(true, std::memory_order_release);
  begin_.notify_one();
  return status;
}

void HapticThread::run() {
  ::pthread_setname_np(::pthread_self(), kHapticThreadName);
  status_ = make_realtime(settings_.cpu);
  session_.warm_up();
  is_ready_.store(true, std::memory_order_release);
  is_ready_.notify_one();
  begin_.wait(false, std::memory_order_acquire);
  const double dt_s = 1.0 / settings_.rate_Hz;
  const double period_ns = static_cast<double>(kSecond_ns) * dt_s;
  meter_.start(settings_.cpu_times_ns);
  const std::int64_t start_ns = monotonic_ns();
  std::int64_t period = 0;
  for (std::uint64_t n = 0; settings_.max_ticks == 0 || n < settings_.max_ticks; ++n) {
    if (stop_.load(std::memory_order_acquire)) break;
    const auto due = [&](std::int64_t k) {
      return start_ns + std::llround(static_cast<double>(k) * period_ns);
    };
    sleep_until(due(period));
    const bool is_late = run_tick(due(period), due(period + 1), dt_s);
    ticks_.store(n + 1, std::memory_order_release);
    ++period;
    if (!is_late) continue;
    missed_deadlines_.fetch_add(1, std::memory_order_acq_rel);
    session_.report_late(cause_of(meter_.cost()), meter_.cost());
    period = static_cast<std::int64_t>(
        std::ceil(static_cast<double>(monotonic_ns() - start_ns) / period_ns));
  }
  meter_.finish();
  session_.stop();
  running_.store(false, std::memory_order_release);
}

bool HapticThread::run_tick(std::int64_t due_ns, std::int64_t next_due_ns, double dt_s) {
  const std::int64_t start_ns = meter_.begin(due_ns);
  session_.tick(dt_s, std::max<std::int64_t>(0, start_ns - due_ns), start_ns);
  return meter_.end(session_.last_step_ns(), session_.last_delay_ns(), next_due_ns);
}

void HapticThread::join() {
  if (thread_.joinable()) {
    thread_.join();
    if (status_.locked_memory) unlock_memory();
  }
}

void HapticThread::stop() {
  stop_.store(true, std::memory_order_release);
  join();
}

}  // namespace palpate
