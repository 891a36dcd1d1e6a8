#include "geometry/parallel.h"

#include <atomic>
#include <thread>

namespace palpate {
namespace {

std::atomic<std::size_t>& cores() {
  static std::atomic<std::size_t> count = std::max(1u, std::thread::hardware_concurrency());
  return count;
}

std::atomic<std::size_t> used = 1;  // the one that starts it all

}  // namespace

std::size_t core_count() {
  return cores();
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
