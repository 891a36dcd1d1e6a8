#pragma once

// How long the ticks of a thread took, and why late ticks were late.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace palpate {

// Counts times in buckets whose upper bounds are 1, 2 and 5 times powers of ten, from 1 us to 1 s;
// the last bucket has no bound.
class TimeHistogram {
 public:
  static constexpr std::size_t kBuckets = 20;

  // Upper bound of a bucket, ns; the largest number for the last one.
  static std::int64_t bound_ns(std::size_t bucket) noexcept;

  void add(std::int64_t time_ns) noexcept;
  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t in_bucket(std::size_t bucket) const noexcept { return buckets_[bucket]; }
  std::int64_t largest_ns() const noexcept { return largest_ns_; }
  // A time that at least this share of all times do not exceed, rounded up to the bound of its
  // bucket, at most largest_ns(). 0 without any time.
  std::int64_t percentile_ns(double share) const noexcept;

 private:
  std::array<std::uint64_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t largest_ns_ = 0;
};

// Why a tick ended after the next one was due.
enum class LateCause : std::uint8_t {
  kWokenLate,  // the system woke the thread late
  kPreempted,  // another thread or the host ran instead
  kPageFault,
  kDevice,  // reading or commanding the device, or an observer
  kOurs     // the loop and the governor
};
inline constexpr std::array<std::string_view, 5> kLateCauseNames = {"woken_late", "preempted",
                                                                    "page_fault", "device", "ours"};

// What one tick cost.
struct TickCost {
  std::int64_t late_ns = 0;      // start minus due time
  std::int64_t wall_ns = 0;      // start to end
  std::int64_t loop_ns = 0;      // the part of wall_ns in the loop
  std::int64_t cpu_ns = 0;       // CPU time of the thread between start and end
  std::int64_t faults = 0;       // page faults since the end of the last tick
  std::int64_t preemptions = 0;  // involuntary context switches since the end of the last tick
};

// The cause with the largest part in the delay.
LateCause cause_of(const TickCost& cost) noexcept;

// The times of all ticks of a thread.
struct TickTimes {
  TimeHistogram late;    // start minus due time
  TimeHistogram period;  // from start to start
  TimeHistogram wall;    // from reading the device to the end of the tick
  TimeHistogram cpu;     // CPU time
  std::array<std::uint64_t, kLateCauseNames.size()> late_ticks{};  // by cause
  TickCost longest;  // of the late tick that took the longest after its due time
};

// Reads the CPU time and the faults of the calling thread. Two system calls, less than 1 us.
class ThreadUsage {
 public:
  struct Reading {
    std::int64_t cpu_ns = 0, faults = 0, preemptions = 0;
  };
  static std::int64_t cpu_ns() noexcept;
  static Reading now() noexcept;
};

}  // namespace palpate
