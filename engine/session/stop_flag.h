#pragma once

#include <atomic>

namespace palpate {

// Requests the orderly end of a long computation. Any thread or signal handler may set the flag.
class StopFlag {
 public:
  void request() noexcept { requested_.store(true, std::memory_order_relaxed); }
  bool requested() const noexcept { return requested_.load(std::memory_order_relaxed); }

 private:
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
  std::atomic<bool> requested_{false};
};

}  // namespace palpate
