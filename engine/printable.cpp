#include "engine/printable.h"

#include <cstddef>
#include <cstdint>

namespace palpate {
namespace {

constexpr char32_t kLargest = 0x10FFFF;
constexpr char32_t kFirstSurrogate = 0xD800;
constexpr char32_t kLastSurrogate = 0xDFFF;
// Of the basic plane's end; XML has no place for them.
constexpr char32_t kFirstNoncharacter = 0xFFFE;
constexpr char32_t kLastNoncharacter = 0xFFFF;

bool is_continuation(char c) {
  return (static_cast<std::uint8_t>(c) & 0xC0) == 0x80;
}

// How many bytes the sequence at the front has, by its first one; 0 if none begins so.
std::size_t announced_length(std::uint8_t first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  if (first >= 0xF0 && first < 0xF5) return 4;
  return 0;
}

// The length of the valid character at the front; 0 if there is none.
std::size_t valid_length(std::string_view text) {
  constexpr std::uint8_t kPayload[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const auto first = static_cast<std::uint8_t>(text.front());
  const std::size_t length = announced_length(first);
  if (length == 0 || length > text.size()) return 0;
  char32_t code = first & kPayload[length];
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(text[i])) return 0;
    code = (code << 6) | (static_cast<std::uint8_t>(text[i]) & 0x3F);
  }
  const bool is_surrogate = code >= kFirstSurrogate && code <= kLastSurrogate;
  const bool is_noncharacter = code >= kFirstNoncharacter && code <= kLastNoncharacter;
  if (code < kSmallest[length] || code > kLargest || is_surrogate || is_noncharacter) return 0;
  return length;
}

bool is_control(std::string_view character) {
  const auto first = static_cast<std::uint8_t>(character.front());
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  return character.size() == 2 && first == 0xC2 && static_cast<std::uint8_t>(character[1]) < 0xA0;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = valid_length(text);
    if (length == 0) {
      out += '?';
      text.remove_prefix(1);
      continue;
    }
    const std::string_view character = text.substr(0, length);
    if (is_control(character)) {
      out += ' ';
    } else {
      out += character;
    }
    text.remove_prefix(length);
  }
  return out;
}

}  // namespace palpate
