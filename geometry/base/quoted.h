#pragma once

// Quotes untrusted text in messages.

#include <string>
#include <string_view>

namespace palpate {

// The text; if it is longer than 120 bytes, its first 120 bytes and "...".
inline std::string shortened(std::string_view text) {
  constexpr std::size_t kMaxLength = 120;
  std::string shown(text.substr(0, kMaxLength));
  if (text.size() > kMaxLength) shown += "...";
  return shown;
}

// The shortened text in quotes.
inline std::string in_quotes(std::string_view text) {
  return "\"" + shortened(text) + "\"";
}

}  // namespace palpate
