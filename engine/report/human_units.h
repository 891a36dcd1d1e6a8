#pragma once

// Numbers as people read them: three digits and a handy unit.

#include <string>
#include <string_view>

namespace palpate {

// What a number is multiplied by to be shown in this unit.
struct DisplayUnit {
  double factor = 1.0;
  std::string name;
};

// The unit in which a number of this size reads well: 1.3e-6 "m" in "µm", 1300 "ns" in "µs". Of m,
// s, N, J, W and Hz, with or without a prefix and over what there is ("N/m"); any other unit is
// kept. So is the plain unit for what is too small for a prefix, and for 0.
DisplayUnit display_unit(double typical, std::string_view unit);

// Three digits, or all before the point: "0.0123", "134", "20480", "1.2e-7".
std::string short_number(double value);

// Of a fitted order: "1.98".
std::string order_number(double order);

// "1.3 µs"; "0" whatever the unit.
std::string human(double value, std::string_view unit);

// "depth error (µm)", or the name alone where there is no unit.
std::string with_unit(std::string_view name, std::string_view unit);

}  // namespace palpate
