#pragma once

// The value of a Result that must have one.

#include <stdexcept>
#include <string>
#include <utility>

#include "geometry/base/result.h"

namespace palpate::test {

// Throws if there is an Error: the test then fails with the line of the caller and the text of the
// Error. Clang 14 has no std::source_location.
template <typename T>
T made(Result<T> result, const char* caller_file = __builtin_FILE(),
       int caller_line = __builtin_LINE()) {
  if (!result) {
    throw std::runtime_error(std::string(caller_file) + ":" + std::to_string(caller_line) + ": " +
                             result.error().to_string());
  }
  return std::move(*result);
}

}  // namespace palpate::test
