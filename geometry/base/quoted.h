#pragma once

// Quotes untrusted text in messages.

#include <string>

namespace palpate {

// The text, cut to 120 bytes and "..." if it is longer.
inline std::string shortened(const std::string& text) {
  constexpr std::size_t kMaxLength = 120;
  return text.size() > kMaxLength ? text.substr(0, kMaxLength) + "..." : text;
}

// The shortened text in quotes.
inline std::string in_quotes(const std::string& text) {
  return "\"" + shortened(text) + "\"";
}

}  // namespace palpate
