#pragma once

// Leaves long runs of spaces out of JSON text. The JSON library keeps a copy of the spaces before
// each value, and examines them one by one.

#include <cstddef>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// A part of a text, from one byte to before another one.
struct JsonTextPart {
  std::size_t begin, end;
};

// The long runs of spaces between the values of a text, each without its last byte, in ascending
// order. An error if a string is longer than kMaxGltfStringBytes; data URIs may be longer. Does not
// check the grammar. Thread-safe.
Result<std::vector<JsonTextPart>> long_spaces(std::string_view text);

// Goes through the bytes of a text, without those of some parts. The text and the parts must
// outlive it.
class JsonTextIterator {
 public:
  using iterator_category = std::forward_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  // at: 0 for the begin, the size of the text for the end. left_out: ascending.
  JsonTextIterator(std::string_view text, std::size_t at, std::span<const JsonTextPart> left_out)
      : text_(text.data()), at_(at), left_out_(left_out) {
    skip();
  }

  reference operator*() const { return text_[at_]; }
  JsonTextIterator& operator++() {
    ++at_;
    skip();
    return *this;
  }
  JsonTextIterator operator++(int) {
    JsonTextIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const JsonTextIterator& other) const { return at_ == other.at_; }
  bool operator!=(const JsonTextIterator& other) const { return at_ != other.at_; }

 private:
  void skip() {
    if (left_out_.empty() || at_ != left_out_.front().begin) return;
    at_ = left_out_.front().end;
    left_out_ = left_out_.subspan(1);
  }

  const char* text_;
  std::size_t at_;
  std::span<const JsonTextPart> left_out_;  // those that are still ahead
};

}  // namespace palpate
