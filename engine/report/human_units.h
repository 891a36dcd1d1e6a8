#pragma once

// Numbers for human readers: three digits and a suitable unit.

#include <string>
#include <string_view>

namespace palpate {

// A unit for display and the factor that converts a number to it.
struct DisplayUnit {
  double factor = 1.0;
  std::string name;
};

// The unit that suits a number of this size: 1.3e-6 "m" in "µm", 1300 "ns" in "µs". Applies to m,
// s, N, J, W and Hz, with or without a prefix, also as a numerator ("N/m"); any other unit is kept.
// Zero, and a number too small for the smallest prefix, has the unit without a prefix.
DisplayUnit display_unit(double typical, std::string_view unit);

// Three digits, or all digits of the integer part: "0.0123", "134", "20480", "1.2e-7".
std::string short_number(double value);

// A fitted order with two decimals: "1.98".
std::string order_number(double order);

// "1.3 µs"; "0" for every unit.
std::string human(double value, std::string_view unit);

// "depth error (µm)", or the name alone if the unit is empty.
std::string with_unit(std::string_view name, std::string_view unit);

}  // namespace palpate
