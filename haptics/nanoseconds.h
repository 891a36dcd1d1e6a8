#pragma once

// Times in whole nanoseconds, whose sums do not round.

#include <cmath>
#include <cstdint>

namespace palpate {

inline constexpr double kNanosecond_s = 1e-9;

inline std::int64_t nanoseconds(double time_s) {
  return std::llround(time_s / kNanosecond_s);
}
constexpr double seconds(std::int64_t ns) {
  return kNanosecond_s * static_cast<double>(ns);
}

}  // namespace palpate
