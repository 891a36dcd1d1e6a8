#pragma once

// Quotes untrusted text in messages.

#include <string>

namespace palpate {

// The text; if it is longer than 120 bytes, its first 120 bytes and "...".
inline std::string shortened(const std::string& text) {
  constexpr std::size_t kMaxLength = 120;
  return text.size() > kMaxLength ? text.substr(0, kMaxLength) + "..." : text;
}

// The shortened text in quotes.
inline std::string in_quotes(const std::string& text) {
  return "\"" + shortened(text) + "\"";
}

}  // namespace palpate
