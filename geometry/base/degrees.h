#pragma once

#include <numbers>

namespace palpate {

inline constexpr double kRadPerDegree = std::numbers::pi / 180.0;
inline constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;

}  // namespace palpate
