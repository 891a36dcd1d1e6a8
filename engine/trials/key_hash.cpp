#include "engine/trials/key_hash.h"

#include <array>
#include <bit>
#include <cstdio>

namespace palpate {

KeyHash& KeyHash::add(std::string_view text) {
  add_byte('t');
  add_number(text.size());
  for (const char c : text) add_byte(static_cast<std::uint8_t>(c));
  return *this;
}

KeyHash& KeyHash::add(std::uint64_t number) {
  add_byte('n');
  add_number(number);
  return *this;
}

KeyHash& KeyHash::add(double number) {
  return add(std::bit_cast<std::uint64_t>(number));
}

std::uint64_t KeyHash::value() const {
  std::uint64_t h = hash_;
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdull;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ull;
  h ^= h >> 33;
  return h;
}

void KeyHash::add_byte(std::uint8_t byte) {
  constexpr std::uint64_t kPrime = 1099511628211ull;
  hash_ = (hash_ ^ byte) * kPrime;
}

void KeyHash::add_number(std::uint64_t number) {
  for (int byte = 0; byte < 8; ++byte) add_byte(static_cast<std::uint8_t>(number >> (8 * byte)));
}

std::string hash_text(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

}  // namespace palpate
