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

// The unit that suits a number of this size: "µm" for 1.3e-6 "m", "µs" for 1300 "ns". The unit
// changes if it is m, s, N, J, W or Hz, with or without a prefix, alone or as a numerator ("N/m");
// any other unit is kept. For zero, and for a number too small for the smallest prefix, the unit
// has no prefix.
DisplayUnit display_unit(double typical, std::string_view unit);

// The number with three digits, or with all digits of its integer part: "0.0123", "134", "20480",
// "1.2e-7".
std::string short_number(double value);

// A fitted order with two decimals: "1.98".
std::string order_number(double order);

// A number with its unit: "1.3 µs". Zero has no unit: "0".
std::string human(double value, std::string_view unit);

// "depth error (µm)", or the name alone if the unit is empty.
std::string with_unit(std::string_view name, std::string_view unit);

}  // namespace palpate
