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

// How far CLOCK_BOOTTIME is ahead of CLOCK_MONOTONIC, ns. It grows by the time for which the
// machine is suspended, and by nothing else. The two clocks are read one after the other, so that
// the first function may return more, and the second one less: a second result above an earlier
// first one proves that the machine was suspended in between. Any thread may call them.
inline std::int64_t boottime_ns() noexcept {
  timespec now;
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}
inline std::int64_t most_boot_ahead_ns() noexcept {
  const std::int64_t before_ns = monotonic_ns();
  return boottime_ns() - before_ns;
}
inline std::int64_t least_boot_ahead_ns() noexcept {
  const std::int64_t boot_ns = boottime_ns();
  return boot_ns - monotonic_ns();
}

}  // namespace palpate
