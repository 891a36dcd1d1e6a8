#pragma once

// A serial port: a terminal in raw mode, which one process owns.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "geometry/base/result.h"

namespace palpate {

// No function blocks. One thread uses an object at a time.
class SerialPort {
 public:
  // Opens the port, locks it, sets raw mode and discards what has arrived before. Two locks keep
  // other programs away: TIOCEXCL, which the superuser passes, and flock(). The Error names the
  // remedy if the port is missing, busy, not permitted, or not a terminal.
  static Result<SerialPort> open(const std::string& path);

  SerialPort(SerialPort&& other) noexcept;
  SerialPort& operator=(SerialPort&& other) noexcept;
  ~SerialPort();

  // The number of bytes that have arrived, at most bytes.size(); no value after a hang-up.
  std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept;
  // The number of bytes that the terminal has taken; no value after a hang-up.
  std::optional<std::size_t> write(std::span<const std::uint8_t> bytes) noexcept;

  // For poll(), and for a process that guards the motors.
  int descriptor() const noexcept { return descriptor_; }

 private:
  explicit SerialPort(int descriptor) noexcept : descriptor_(descriptor) {}
  void close() noexcept;

  int descriptor_ = -1;
};

}  // namespace palpate
