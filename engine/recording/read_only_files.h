#pragma once

// A file system layer of SQLite that only reads.

#include <cstdint>

namespace palpate {

// A number of at most 4 bytes, as SQLite's files have it.
constexpr std::uint32_t big_endian(const unsigned char* bytes, int count) noexcept {
  std::uint32_t number = 0;
  for (int i = 0; i < count; ++i) number = number << 8 | bytes[i];
  return number;
}

// Registers the layer and returns its SQLite name; null if SQLite has no memory. Files are opened
// for reading, nothing is ever created, written, removed, locked or mapped, and the index of a
// write-ahead log lies in the reader's own memory. So a log that a crash has left is used even
// where the folder cannot be written. Thread-safe.
const char* read_only_files() noexcept;

}  // namespace palpate
