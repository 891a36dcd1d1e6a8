#pragma once

#include <array>
#include <charconv>
#include <string>

namespace palpate {

// The fewest digits that identify the number, as in the paper and in plans: "836.377", "25".
inline std::string as_printed(double value) {
  std::array<char, 64> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), end.ptr);
}

}  // namespace palpate
