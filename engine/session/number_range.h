#pragma once

#include <limits>

namespace palpate {

// A range of finite numbers. By default, it contains all of them.
struct NumberRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool is_least_out = false;  // the range excludes `least` itself

  constexpr bool contains(double x) const {
    return x >= least && x <= most && !(is_least_out && x == least);
  }
};
inline constexpr NumberRange kAboveZero{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr NumberRange kZeroOrMore{0.0};

}  // namespace palpate
