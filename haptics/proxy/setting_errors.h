#pragma once

// Helpers that report invalid settings by the name of the field. They allocate; not for the haptic
// thread.

#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include "geometry/base/result.h"

namespace palpate {

// The value with 17 significant digits.
inline std::string digits_of(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

// Reports an Error unless the value is finite and positive, or 0 if zero_allowed.
inline std::optional<Error> check_number(const char* field, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return std::nullopt;
  return invalid_argument(field, "is " + digits_of(value) + "; expected a finite number " +
                                     (zero_allowed ? ">= 0" : "> 0"));
}

}  // namespace palpate
