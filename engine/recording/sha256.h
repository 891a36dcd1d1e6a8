#pragma once

// The hash SHA-256 (FIPS 180-4).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace palpate {

// 64 hexadecimal digits, lower case.
std::string sha256_hex(std::span<const std::uint8_t> bytes);

}  // namespace palpate
