#pragma once

// The hash that turns the key of a random number, or the content of a file, into 64 bits.

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// Hashes a list of fields. The same fields in the same order give the same value on every platform
// and in every version of Palpate: seeds of trials and the identity of runs depend on it.
//
// Definition. A text field is the byte 't', the length of the text in bytes and the text; a number
// field is the byte 'n' and the number. Lengths and numbers are 8 bytes, the lowest first. FNV-1a
// with 64 bits hashes these bytes: h = 14695981039346656037 at the start, then for each byte
// h = (h xor byte) * 1099511628211 mod 2^64. value() is h after the finalizer of MurmurHash3:
// h ^= h >> 33, h *= 0xff51afd7ed558ccd, h ^= h >> 33, h *= 0xc4ceb9fe1a85ec53, h ^= h >> 33.
// Because of the lengths, no two different lists have the same bytes. Because of the finalizer,
// keys that differ in one bit have values that differ in about half of their bits.
//
// Not for secrets: it is easy to construct two texts with the same hash.
class KeyHash {
 public:
  KeyHash& add(std::string_view text);
  KeyHash& add(std::uint64_t number);
  // The bits of the number; -0.0 and 0.0 differ.
  KeyHash& add(double number);

  std::uint64_t value() const;

 private:
  void add_byte(std::uint8_t byte);
  void add_number(std::uint64_t number);

  std::uint64_t hash_ = 14695981039346656037ull;
};

// 16 hexadecimal digits, lower case.
std::string hash_text(std::uint64_t hash);

}  // namespace palpate
