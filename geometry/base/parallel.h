#pragma once

// Parallel work on the cores of the machine. Load time only: the functions start threads.
//
// Results must not depend on the thread that does the work or on the number of threads. Work may
// itself start parallel work: the number of running threads never exceeds the number of cores.

#include <algorithm>
#include <cstddef>
#include <future>
#include <new>
#include <system_error>
#include <utility>

namespace palpate {

// The number of cores used for parallel work, at least 1. These are the cores to which the process
// was bound at the first call, or else all cores of the machine.
std::size_t core_count();
// The number of parts into which to divide work if each part reads the whole input. It is the
// number of cores or, if smaller, the number of parts beyond which further parts save no time.
std::size_t pass_count();
// Overrides core_count() for tests. Must not be called while parallel work runs.
void assume_cores(std::size_t count);

// Reserves a core that runs no parallel work, until this object is destroyed. is_taken() is false
// if no core was free.
class SpareCore {
 public:
  SpareCore();
  ~SpareCore();
  SpareCore(SpareCore&& other) noexcept : is_taken_(std::exchange(other.is_taken_, false)) {}
  SpareCore& operator=(SpareCore&&) = delete;

  bool is_taken() const { return is_taken_; }

 private:
  bool is_taken_;
};

// Calls work() on a new thread. Returns an invalid future, and does not call work(), if the system
// lacks memory or threads.
template <typename Work>
std::future<void> start_thread(const Work& work) {
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
  return {};
}

// Calls first() and second(), in parallel if a core is free. Returns when both have returned.
// Rethrows the exception of the function that throws; if both throw, the exception of first() is
// rethrown.
template <typename First, typename Second>
void run_both(const First& first, const Second& second) {
  SpareCore core;
  if (!core.is_taken()) {
    first();
    second();
    return;
  }
  std::future<void> other = start_thread([&] {
    const SpareCore in_use = std::move(core);  // given back when second() has returned
    second();
  });
  first();
  if (other.valid()) return other.get();
  second();
}

// Calls work(i) for begin <= i < end, in any order.
template <typename Work>
void run_each(std::size_t begin, std::size_t end, const Work& work) {
  if (begin >= end) return;
  if (end - begin == 1) return work(begin);
  const std::size_t middle = begin + (end - begin) / 2;
  run_both([&] { run_each(begin, middle, work); }, [&] { run_each(middle, end, work); });
}

// Divides 0 .. items into ranges of at least `least` items (a single range may be shorter) and
// calls work(begin, end) for each range, in any order.
template <typename Work>
void run_ranges(std::size_t items, std::size_t least, const Work& work) {
  // More ranges than cores, since a core may become free later.
  constexpr std::size_t kRangesPerCore = 8;
  const std::size_t most = core_count() == 1 ? 1 : kRangesPerCore * core_count();
  const std::size_t ranges = std::clamp<std::size_t>(items / least, 1, most);
  run_each(0, ranges, [&](std::size_t i) { work(items * i / ranges, items * (i + 1) / ranges); });
}

}  // namespace palpate
