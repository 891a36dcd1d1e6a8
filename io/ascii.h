#pragma once

// Letters and digits of ASCII, in every locale. Bytes of other characters are neither.

#include <algorithm>
#include <string_view>

namespace palpate {

constexpr bool is_upper(char c) noexcept {
  return c >= 'A' && c <= 'Z';
}
constexpr bool is_lower(char c) noexcept {
  return c >= 'a' && c <= 'z';
}
constexpr bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}
// The small letter of a capital one; every other character as it is.
constexpr char lower(char c) noexcept {
  return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
}
// Whether the text begins with `start`, which is in small letters, in letters of any case.
constexpr bool starts_with_ignoring_case(std::string_view text, std::string_view start) noexcept {
  return text.size() >= start.size() &&
         std::equal(start.begin(), start.end(), text.begin(),
                    [](char expected, char c) { return lower(c) == expected; });
}

}  // namespace palpate
