#pragma once

// How long the ticks of a thread took, and why late ticks were late.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace palpate {

// Counts times from 0 to 17 s, the last bucket all longer ones. Times below 64 ns have a bucket
// each; above, each power of two is divided into 32 buckets, so that the bound of a bucket exceeds
// its times by at most 1/32.
class TimeHistogram {
 public:
  static constexpr std::size_t kBuckets = 961;

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
  std::int64_t late_ns = 0;   // start minus due time
  std::int64_t wall_ns = 0;   // start to end
  std::int64_t loop_ns = 0;   // the part of wall_ns in the loop
  std::int64_t delay_ns = 0;  // start to the command of the force
  std::int64_t cpu_ns = 0;    // CPU time of the thread between start and end
  // Page faults and involuntary context switches, in this tick or since the end of the last tick
  // that was late or had to wait; 0 for a tick that is not late and did not wait.
  std::int64_t faults = 0;
  std::int64_t preemptions = 0;
};

// The cause with the largest part in the delay.
LateCause cause_of(const TickCost& cost) noexcept;

struct LateTick {
  std::uint64_t tick = 0;
  TickCost cost;
};

// Keeps the first late ticks.
class LateTickLog {
 public:
  static constexpr std::size_t kMost = 1024;

  void add(const LateTick& tick) noexcept {
    if (count_ < kMost) ticks_[count_++] = tick;
  }
  std::span<const LateTick> ticks() const noexcept { return std::span(ticks_).first(count_); }

 private:
  std::array<LateTick, kMost> ticks_{};
  std::size_t count_ = 0;
};

// The times of all ticks of a thread.
struct TickTimes {
  TimeHistogram late;    // start minus due time
  TimeHistogram period;  // from start to start
  TimeHistogram wall;    // from reading the device to the end of the tick
  TimeHistogram cpu;     // CPU time of the tick
  TimeHistogram step;    // the loop's part of wall
  TimeHistogram delay;   // from reading the device to its command
  std::array<std::uint64_t, kLateCauseNames.size()> late_ticks{};  // by cause
  LateTickLog late_log;
  TickCost longest;              // of the late tick that took the longest after its due time
  std::int64_t faults = 0;       // page faults of the thread
  std::int64_t preemptions = 0;  // involuntary context switches of the thread

  void add_late(const LateTick& tick) noexcept;
  std::uint64_t all_late_ticks() const noexcept;
};

// Reads the CPU time and the faults of the calling thread, one system call each.
class ThreadUsage {
 public:
  struct Reading {
    std::int64_t faults = 0, preemptions = 0;
  };
  static std::int64_t cpu_ns() noexcept;
  static Reading now() noexcept;
};

// Measures the ticks of one thread, in less than 1 us each. One thread owns an object.
class TickMeter {
 public:
  // Call it on the thread that is measured, before the first tick. cpu_ns: receives the CPU times
  // of as many ticks as it has room for, at most 4.2 s each.
  void start(std::span<std::uint32_t> cpu_ns = {}) noexcept {
    cpu_times_ns_ = cpu_ns;
    usage_ = ThreadUsage::now();
  }
  // Call it at the begin of a tick. Returns the time, which is the start of the tick. due_ns: on
  // the monotonic clock.
  std::int64_t begin(std::int64_t due_ns) noexcept;
  // Call it at the end of a tick. loop_ns, delay_ns: as in TickCost. next_due_ns: the tick is late
  // if it ends after this time. Returns whether it is late.
  bool end(std::int64_t loop_ns, std::int64_t delay_ns, std::int64_t next_due_ns) noexcept;
  // Call it after the last tick, before times().
  void finish() noexcept { read_usage(); }

  const TickCost& cost() const noexcept { return cost_; }  // of the last tick
  const TickTimes& times() const noexcept { return times_; }

 private:
  void read_usage() noexcept;

  TickTimes times_;
  std::span<std::uint32_t> cpu_times_ns_;
  TickCost cost_;
  ThreadUsage::Reading usage_;  // when the faults were last read
  std::uint64_t ticks_ = 0;
  std::int64_t start_ns_ = 0;  // of the last tick; 0 before the first one
  std::int64_t cpu_start_ns_ = 0;
};

}  // namespace palpate
