#pragma once

// Conversion between the paper's degrees and the engine's radians.

#include <numbers>

namespace palpate::test {

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}
inline double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

}  // namespace palpate::test
