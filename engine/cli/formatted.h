#pragma once

#include <cstdio>
#include <string>

namespace palpate {

// The text that printf() would write, cut after 239 bytes.
template <typename... Args>
std::string formatted(const char* pattern, Args... args) {
  char text[240];
  std::snprintf(text, sizeof text, pattern, args...);
  return text;
}

}  // namespace palpate
