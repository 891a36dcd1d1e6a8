#include "engine/session/tick_times.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <sys/resource.h>
#include <time.h>

#include "engine/devices/monotonic_clock.h"

namespace palpate {
namespace {

// Bits of a time that select its bucket within a power of two.
constexpr int kFineBits = 5;
constexpr std::size_t kFine = std::size_t{1} << kFineBits;

constexpr std::size_t bucket_of(std::uint64_t time_ns) {
  const int shift = std::max(0, static_cast<int>(std::bit_width(time_ns)) - kFineBits - 1);
  const std::size_t bucket = static_cast<std::size_t>(shift) * kFine + (time_ns >> shift);
  return std::min(bucket, TimeHistogram::kBuckets - 1);
}

}  // namespace

std::int64_t TimeHistogram::bound_ns(std::size_t bucket) noexcept {
  if (bucket + 1 >= kBuckets) return std::numeric_limits<std::int64_t>::max();
  if (bucket < 2 * kFine) return static_cast<std::int64_t>(bucket);
  const std::size_t shift = bucket / kFine - 1;
  return static_cast<std::int64_t>(((bucket - shift * kFine + 1) << shift) - 1);
}

void TimeHistogram::add(std::int64_t time_ns) noexcept {
  ++buckets_[bucket_of(static_cast<std::uint64_t>(std::max<std::int64_t>(0, time_ns)))];
  ++count_;
  largest_ns_ = std::max(largest_ns_, time_ns);
}

std::int64_t TimeHistogram::percentile_ns(double share) const noexcept {
  const double rank = std::ceil(share * static_cast<double>(count_));
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    below += buckets_[i];
    if (below > 0 && static_cast<double>(below) >= rank) return std::min(bound_ns(i), largest_ns_);
  }
  return largest_ns_;
}

std::uint64_t TickTimes::all_late_ticks() const noexcept {
  return std::accumulate(late_ticks.begin(), late_ticks.end(), std::uint64_t{0});
}

void TickTimes::add_late(const LateTick& tick) noexcept {
  ++late_ticks[static_cast<std::size_t>(cause_of(tick.cost))];
  late_log.add(tick);
  const auto end_ns = [](const TickCost& c) { return c.late_ns + c.wall_ns; };
  if (end_ns(tick.cost) > end_ns(longest)) longest = tick.cost;
}

LateCause cause_of(const TickCost& cost) noexcept {
  const std::int64_t waiting_ns = std::max<std::int64_t>(0, cost.wall_ns - cost.cpu_ns);
  const std::int64_t running_ns = std::min(cost.cpu_ns, cost.wall_ns);
  const std::int64_t device_ns = cost.wall_ns - cost.loop_ns;
  if (cost.late_ns >= std::max(waiting_ns, running_ns)) return LateCause::kWokenLate;
  if (running_ns > waiting_ns) {
    return device_ns > cost.loop_ns ? LateCause::kDevice : LateCause::kOurs;
  }
  if (cost.preemptions > 0) return LateCause::kPreempted;
  if (cost.faults > 0) return LateCause::kPageFault;
  // The thread waited by itself, which the loop never does; or the host took the CPU away.
  return device_ns > cost.loop_ns ? LateCause::kDevice : LateCause::kPreempted;
}

std::int64_t ThreadUsage::cpu_ns() noexcept {
  timespec cpu{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
  return cpu.tv_sec * kSecond_ns + cpu.tv_nsec;
}

ThreadUsage::Reading ThreadUsage::now() noexcept {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt + usage.ru_majflt, usage.ru_nivcsw};
}

namespace {

// A tick that waits loses the CPU for longer than this: a context switch to another thread and
// back, or a page fault, takes more. Then the system is asked for the reason.
constexpr std::int64_t kWaited_ns = 2000;

}  // namespace

std::int64_t TickMeter::begin(std::int64_t due_ns) noexcept {
  cpu_start_ns_ = ThreadUsage::cpu_ns();
  const std::int64_t now_ns = monotonic_ns();
  if (start_ns_ != 0) times_.period.add(now_ns - start_ns_);
  start_ns_ = now_ns;
  cost_.late_ns = std::max<std::int64_t>(0, now_ns - due_ns);
  return now_ns;
}

bool TickMeter::end(std::int64_t loop_ns, std::int64_t delay_ns,
                    std::int64_t next_due_ns) noexcept {
  const std::int64_t now_ns = monotonic_ns();
  cost_.wall_ns = now_ns - start_ns_;
  cost_.cpu_ns = ThreadUsage::cpu_ns() - cpu_start_ns_;
  cost_.loop_ns = loop_ns;
  cost_.delay_ns = delay_ns;
  cost_.faults = cost_.preemptions = 0;
  const bool is_late = now_ns > next_due_ns;
  if (is_late || cost_.wall_ns > cost_.cpu_ns + kWaited_ns) read_usage();
  times_.late.add(cost_.late_ns);
  times_.wall.add(cost_.wall_ns);
  times_.cpu.add(cost_.cpu_ns);
  times_.step.add(loop_ns);
  times_.delay.add(delay_ns);
  if (ticks_ < cpu_times_ns_.size()) {
    constexpr std::int64_t kMost_ns = std::numeric_limits<std::uint32_t>::max();
    cpu_times_ns_[ticks_] =
        static_cast<std::uint32_t>(std::clamp<std::int64_t>(cost_.cpu_ns, 0, kMost_ns));
  }
  if (is_late) times_.add_late({ticks_, cost_});
  ++ticks_;
  return is_late;
}

void TickMeter::read_usage() noexcept {
  const ThreadUsage::Reading usage = ThreadUsage::now();
  cost_.faults = usage.faults - usage_.faults;
  cost_.preemptions = usage.preemptions - usage_.preemptions;
  times_.faults += cost_.faults;
  times_.preemptions += cost_.preemptions;
  usage_ = usage;
}

}  // namespace palpate
