#include "engine/session/tick_times.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <sys/resource.h>
#include <time.h>

namespace palpate {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

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

namespace {

bool is_slower(const SlowTick& a, const SlowTick& b) {
  return a.cpu_ns != b.cpu_ns ? a.cpu_ns > b.cpu_ns : a.tick < b.tick;
}

}  // namespace

void SlowestTicks::add(const SlowTick& tick) noexcept {
  const auto begin = heap_.begin();
  if (count_ < kMost) {
    heap_[count_++] = tick;
    std::push_heap(begin, begin + static_cast<std::ptrdiff_t>(count_), is_slower);
    return;
  }
  if (!is_slower(tick, heap_.front())) return;
  std::pop_heap(begin, heap_.end(), is_slower);
  heap_.back() = tick;
  std::push_heap(begin, heap_.end(), is_slower);
}

std::vector<SlowTick> SlowestTicks::sorted() const {
  std::vector<SlowTick> ticks(heap_.begin(), heap_.begin() + static_cast<std::ptrdiff_t>(count_));
  std::sort(ticks.begin(), ticks.end(), is_slower);
  return ticks;
}

std::uint64_t TickTimes::all_late_ticks() const noexcept {
  return std::accumulate(late_ticks.begin(), late_ticks.end(), std::uint64_t{0});
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
  return {cpu_ns(), usage.ru_minflt + usage.ru_majflt, usage.ru_nivcsw};
}

}  // namespace palpate
