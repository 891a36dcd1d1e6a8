#pragma once

// Finds long runs of spaces in JSON text, and leaves them and the data of data URIs out. The JSON
// library keeps a copy of the spaces before each value, and examines all bytes one by one.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>

namespace palpate {

// A part of a text, from one byte to before another one.
struct JsonTextPart {
  std::size_t begin, end;
};

// A part that is left out, and what a parser gets in its place.
struct JsonReplacement {
  JsonTextPart part;
  std::string_view text;
};

// Whether JSON allows this byte between values.
inline bool is_json_space(char c) {
  return (c == ' ') | (c == '\t') | (c == '\r') | (c == '\n');
}

// The first byte from `at` on for which is_end() is true, or the size of the text. Many bytes are
// examined at once, in a loop without a branch, which compilers turn into vector instructions.
template <typename IsEnd>
std::size_t first_json_byte(std::string_view text, std::size_t at, IsEnd is_end) {
  constexpr std::size_t kAtOnce = 64;
  constexpr std::size_t kShort = 16;  // most strings and runs of spaces are shorter
  const std::size_t short_end = std::min(text.size(), at + kShort);
  for (; at < short_end; ++at) {
    if (is_end(text[at])) return at;
  }
  while (text.size() - at >= kAtOnce) {
    std::uint8_t found = 0;
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      found = static_cast<std::uint8_t>(found | (is_end(text[at + k]) ? 1 : 0));
    }
    if (found != 0) break;
    at += kAtOnce;
  }
  while (at < text.size() && !is_end(text[at])) ++at;
  return at;
}

// The first byte from `at` on that is no space, or the size of the text.
inline std::size_t first_json_mark(std::string_view text, std::size_t at) {
  return first_json_byte(text, at, [](char c) { return !is_json_space(c); });
}

// Goes through the bytes of a text, in which some parts are replaced. The text and the replacements
// must outlive it.
class JsonTextIterator {
 public:
  using iterator_category = std::forward_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  // at: 0 for the begin, the size of the text for the end. replacements: ascending.
  JsonTextIterator(std::string_view text, std::size_t at,
                   std::span<const JsonReplacement> replacements)
      : text_(text.data()), at_(at), replacements_(replacements) {
    skip();
  }

  reference operator*() const { return instead_.empty() ? text_[at_] : instead_.front(); }
  JsonTextIterator& operator++() {
    if (instead_.empty()) {
      ++at_;
    } else {
      instead_.remove_prefix(1);
    }
    skip();
    return *this;
  }
  JsonTextIterator operator++(int) {
    JsonTextIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const JsonTextIterator& other) const {
    return at_ == other.at_ && instead_.size() == other.instead_.size();
  }
  bool operator!=(const JsonTextIterator& other) const { return !(*this == other); }

 private:
  void skip() {
    if (!instead_.empty() || replacements_.empty() || at_ != replacements_.front().part.begin) {
      return;
    }
    at_ = replacements_.front().part.end;
    instead_ = replacements_.front().text;
    replacements_ = replacements_.subspan(1);
  }

  const char* text_;
  std::size_t at_;
  std::string_view instead_;                       // what is left of a replacement
  std::span<const JsonReplacement> replacements_;  // those that are still ahead
};

}  // namespace palpate
