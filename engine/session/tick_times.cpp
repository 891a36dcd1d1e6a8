#include "engine/session/tick_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sys/resource.h>
#include <time.h>

namespace palpate {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

constexpr std::array<std::int64_t, TimeHistogram::kBuckets> make_bounds() {
  std::array<std::int64_t, TimeHistogram::kBuckets> bounds{};
  std::int64_t decade_ns = 1000;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    constexpr std::array<std::int64_t, 3> kSteps = {1, 2, 5};
    bounds[i] = kSteps[i % 3] * decade_ns;
    if (i % 3 == 2) decade_ns *= 10;
  }
  bounds.back() = std::numeric_limits<std::int64_t>::max();
  return bounds;
}
constexpr auto kBounds = make_bounds();
static_assert(kBounds[TimeHistogram::kBuckets - 2] == kSecond_ns);

}  // namespace

std::int64_t TimeHistogram::bound_ns(std::size_t bucket) noexcept {
  return kBounds[bucket];
}

void TimeHistogram::add(std::int64_t time_ns) noexcept {
  const auto bucket = std::lower_bound(kBounds.begin(), kBounds.end() - 1, time_ns);
  ++buckets_[static_cast<std::size_t>(bucket - kBounds.begin())];
  ++count_;
  largest_ns_ = std::max(largest_ns_, time_ns);
}

std::int64_t TimeHistogram::percentile_ns(double share) const noexcept {
  const double rank = std::ceil(share * static_cast<double>(count_));
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    below += buckets_[i];
    if (below > 0 && static_cast<double>(below) >= rank) return std::min(kBounds[i], largest_ns_);
  }
  return largest_ns_;
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
