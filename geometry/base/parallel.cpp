#include "geometry/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <sched.h>
#include <thread>

namespace palpate {
namespace {

std::size_t cores_of_this_process() {
  cpu_set_t bound_to;
  if (sched_getaffinity(0, sizeof bound_to, &bound_to) == 0) {
    return static_cast<std::size_t>(CPU_COUNT(&bound_to));
  }
  return std::thread::hardware_concurrency();  // more cores than a cpu_set_t can hold
}

std::atomic<std::size_t>& cores() {
  static std::atomic<std::size_t> count = std::max<std::size_t>(cores_of_this_process(), 1);
  return count;
}

std::atomic<std::size_t> used = 1;  // the main thread's core

}  // namespace

std::size_t core_count() {
  return cores();
}

std::size_t pass_count() {
  constexpr std::size_t kMostPasses = 8;
  return std::min(core_count(), kMostPasses);
}

void assume_cores(std::size_t count) {
  cores() = std::max<std::size_t>(count, 1);
}

SpareCore::SpareCore() : is_taken_(true) {
  std::size_t now = used;
  while (now < core_count()) {
    if (used.compare_exchange_weak(now, now + 1)) return;
  }
  is_taken_ = false;
}

SpareCore::~SpareCore() {
  if (is_taken_) --used;
}

}  // namespace palpate
