#include "engine/viewer/token.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <sys/random.h>
#include <system_error>

namespace palpate {

Token Token::make() {
  std::array<std::uint8_t, kDigits / 2> bytes{};
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t n = ::getrandom(bytes.data() + filled, bytes.size() - filled, 0);
    if (n < 0 && errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "no random numbers (getrandom)");
    }
    if (n > 0) filled += static_cast<std::size_t>(n);
  }
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kHex[byte >> 4];
    text += kHex[byte & 15];
  }
  return Token(std::move(text));
}

bool Token::equals(std::string_view text) const noexcept {
  if (text.size() != text_.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    difference |= static_cast<unsigned char>(text[i]) ^ static_cast<unsigned char>(text_[i]);
  }
  // The compiler must not know that a difference decides, or it may end the loop early.
  asm volatile("" : "+r"(difference));
  return difference == 0;
}

std::optional<std::size_t> place_of(std::string_view text, std::span<const Token> tokens) noexcept {
  std::optional<std::size_t> place;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (tokens[i].equals(text)) place = i;
  }
  return place;
}

}  // namespace palpate
