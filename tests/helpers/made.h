#pragma once

// The value of a Result that must have one.

#include <source_location>
#include <stdexcept>
#include <string>
#include <utility>

#include "geometry/base/result.h"

namespace palpate::test {

// Throws if there is an Error: the test then fails with the line of the caller and the text of the
// Error.
template <typename T>
T made(Result<T> result, const std::source_location& caller = std::source_location::current()) {
  if (!result) {
    throw std::runtime_error(std::string(caller.file_name()) + ":" + std::to_string(caller.line()) +
                             ": " + result.error().to_string());
  }
  return std::move(*result);
}

}  // namespace palpate::test
