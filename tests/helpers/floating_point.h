#pragma once

// The rounding of doubles and floats, and the values infinity and NaN.

#include <limits>

namespace palpate::test {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
inline constexpr double kFloatRoundoff = 0x1p-24;  // relative rounding error of a float
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace palpate::test
