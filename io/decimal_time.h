#pragma once

// Times in decimal digits, as whole femtoseconds.

#include <cstdint>
#include <string_view>

namespace palpate {

__extension__ typedef __int128 Int128;

// A unit of time: factor * 10^power nanoseconds.
struct TimeScale {
  std::int64_t factor = 1;  // 1 to 86400, so that 30 digits times a factor fit into an Int128
  int power = 9;
};

enum class TimeTextKind : std::uint8_t { kTime, kNotFinite, kOutOfRange, kNone };

struct TimeText {
  TimeTextKind kind = TimeTextKind::kNone;
  Int128 fs = 0;  // of kTime: rounded down, so that no later rounding to ns rounds twice
};

inline constexpr std::int64_t kFemtosecondsPerNanosecond = 1'000'000;

// Reads a decimal number such as "-1.5e3" exactly: no digit passes through a double, in which the
// seconds since 1970 have steps of 238 ns. kNotFinite: nan or inf. kOutOfRange: 1e12 s (30,000
// years) or more. kNone: no number. Thread-safe.
TimeText read_time(std::string_view text, TimeScale scale) noexcept;

// The whole nanoseconds between two times, earlier_fs <= later_fs. It is the difference of the
// rounded times, so that lengths add up without drift, with one exception: sums of doubles, such as
// 0.001 added a million times, drift themselves. Where the difference is a whole number of
// nanoseconds up to the rounding of such a sum, it is that number.
std::int64_t nanoseconds_between(Int128 earlier_fs, Int128 later_fs) noexcept;

}  // namespace palpate
