#pragma once

// The secret that a page must know to see or move anything.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

// 128 random bits as 32 lower-case hexadecimal digits.
class Token {
 public:
  static constexpr std::size_t kDigits = 32;

  // From the system's random numbers. Waits at most as long as the system needs to collect them
  // after its start.
  static Token make();

  const std::string& text() const { return text_; }
  // Takes the same time for every text of this length, so that the time of an answer says nothing
  // about the digits. Only the length can be told.
  bool equals(std::string_view text) const noexcept;

 private:
  explicit Token(std::string text) : text_(std::move(text)) {}

  std::string text_;
};

// The place of the token with this text; no value: none has it. Takes the same time whichever has
// it.
std::optional<std::size_t> place_of(std::string_view text, std::span<const Token> tokens) noexcept;

}  // namespace palpate
