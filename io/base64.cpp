#include "io/base64.h"

#include <array>

namespace palpate {
namespace {

constexpr std::uint8_t kNotADigit = 0xff;

constexpr std::array<std::uint8_t, 256> digit_table() {
  std::array<std::uint8_t, 256> table{};
  table.fill(kNotADigit);
  std::uint8_t value = 0;
  for (const char c :
       std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")) {
    table[static_cast<unsigned char>(c)] = value++;
  }
  return table;
}

constexpr std::array<std::uint8_t, 256> kDigits = digit_table();

// The text without its padding.
std::string_view digits_of(std::string_view text) {
  if (text.size() % 4 == 0 && text.ends_with('=')) text.remove_suffix(text.ends_with("==") ? 2 : 1);
  return text;
}

std::uint32_t digit(char c) {
  return kDigits[static_cast<unsigned char>(c)];
}

}  // namespace

std::optional<std::size_t> base64_size(std::string_view text) {
  const std::size_t digits = digits_of(text).size();
  if (digits % 4 == 1) return std::nullopt;
  return digits / 4 * 3 + digits % 4 * 3 / 4;
}

bool decode_base64(std::string_view text, std::uint8_t* bytes) {
  text = digits_of(text);
  constexpr std::uint32_t kMostDigit = 63;
  std::uint32_t all = 0;  // the bits of all digits
  const char* c = text.data();
  for (std::size_t left = text.size() / 4; left > 0; --left, c += 4, bytes += 3) {
    const std::uint32_t d[4] = {digit(c[0]), digit(c[1]), digit(c[2]), digit(c[3])};
    all |= d[0] | d[1] | d[2] | d[3];
    const std::uint32_t bits = d[0] << 18 | d[1] << 12 | d[2] << 6 | d[3];
    bytes[0] = static_cast<std::uint8_t>(bits >> 16);
    bytes[1] = static_cast<std::uint8_t>(bits >> 8);
    bytes[2] = static_cast<std::uint8_t>(bits);
  }
  const std::size_t rest = text.size() % 4;
  if (rest >= 2) {
    const std::uint32_t d[3] = {digit(c[0]), digit(c[1]), rest > 2 ? digit(c[2]) : 0};
    all |= d[0] | d[1] | d[2];
    const std::uint32_t bits = d[0] << 18 | d[1] << 12 | d[2] << 6;
    bytes[0] = static_cast<std::uint8_t>(bits >> 16);
    if (rest > 2) bytes[1] = static_cast<std::uint8_t>(bits >> 8);
  }
  return rest != 1 && all <= kMostDigit;
}

}  // namespace palpate
