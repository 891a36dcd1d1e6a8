#pragma once

// Disk space for the write-ahead log of a recording.

#include <cstdint>
#include <string>

namespace palpate {

// Takes the space of a file before it is written, so that a full disk is found before a transaction
// begins and the last rows find their space. Does I/O. One thread at a time may use it.
class LogSpace {
 public:
  LogSpace() = default;
  // Opens the file, which must exist; reserve() says if that failed.
  explicit LogSpace(const std::string& path);
  ~LogSpace();
  LogSpace(LogSpace&& other) noexcept;
  LogSpace& operator=(LogSpace&& other) noexcept;

  // Takes the space of the first `bytes` of the file. What the file holds stays; behind its end are
  // zeros. Returns 0, or the number of the system's error. What was taken before stays taken.
  int reserve(std::uint64_t bytes);
  // Gives back the space behind the first `bytes`.
  void cut(std::uint64_t bytes);

 private:
  int write_zeros(std::uint64_t bytes) const;

  int descriptor_ = -1;
  int problem_ = 0;
  std::uint64_t reserved_ = 0;
};

}  // namespace palpate
