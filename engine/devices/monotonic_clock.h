#pragma once

#include <cstdint>
#include <time.h>

namespace palpate {

inline constexpr std::int64_t kSecond_ns = 1'000'000'000;

// The time on CLOCK_MONOTONIC, ns, which all processes share. Not a system call on common
// processors. Any thread may call it.
inline std::int64_t monotonic_ns() noexcept {
  timespec now;
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

}  // namespace palpate
