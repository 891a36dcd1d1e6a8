#pragma once

// Text that somebody else wrote, in a message.

#include <string>

namespace palpate {

// Short enough for a message.
inline std::string shortened(const std::string& text) {
  constexpr std::size_t kMaxLength = 120;
  return text.size() > kMaxLength ? text.substr(0, kMaxLength) + "..." : text;
}

// The same in quotes.
inline std::string in_quotes(const std::string& text) {
  return "\"" + shortened(text) + "\"";
}

}  // namespace palpate
