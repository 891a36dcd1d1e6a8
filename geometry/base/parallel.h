#pragma once

// Work shared among the cores of the machine. Load time only: threads are started.
//
// What is done must not depend on which thread does it, or on how many there are. Work may itself
// be shared again: no more threads run at once than there are cores.

#include <algorithm>
#include <cstddef>
#include <future>
#include <new>
#include <system_error>
#include <utility>

namespace palpate {

// How many cores the work here uses: those of the machine, or of its part that the process was
// bound to when this was first called; 1 at least.
std::size_t core_count();
// The parts that work is divided into of which each goes through all there is: as many as cores,
// but no more than gain by it.
std::size_t pass_count();
// As if there were so many, for tests. Not while work is being done.
void assume_cores(std::size_t count);

// A core on which no work that is shared here runs, until this object ends. There may be none.
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

// Calls work() on a thread of its own. No future where the system has no memory for one, or no
// thread: work() is not called then.
template <typename Work>
std::future<void> start_thread(const Work& work) {
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
  return {};
}

// Calls first() and second(), at the same time if a core is to spare. Returns when both have
// returned; throws what one of them threw, of two the first.
template <typename First, typename Second>
void run_both(const First& first, const Second& second) {
  SpareCore core;
  if (!core.is_taken()) {
    first();
    second();
    return;
  }
  std::future<void> other = start_thread([&] {
    const SpareCore in_use = std::move(core);  // given back before first() has returned
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

// Calls work(begin, end) for ranges that together are 0 .. items, of `least` or more each, in any
// order.
template <typename Work>
void run_ranges(std::size_t items, std::size_t least, const Work& work) {
  // More than cores: one may become free only later.
  constexpr std::size_t kRangesPerCore = 8;
  const std::size_t most = core_count() == 1 ? 1 : kRangesPerCore * core_count();
  const std::size_t ranges = std::clamp<std::size_t>(items / least, 1, most);
  run_each(0, ranges, [&](std::size_t i) { work(items * i / ranges, items * (i + 1) / ranges); });
}

}  // namespace palpate
