#pragma once

// Writes images as PNG files with identical bytes on every platform. The files have no filter,
// compression, time or colour space. Only the checksums come from a library, because another
// version of a compression library may give different bytes for the same pixels. Thread-safe.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

// The pixels are stored row by row from the top left.
template <typename Pixel>
struct Image {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Pixel> pixels;
};

using GreyImage = Image<std::uint16_t>;               // 65535 represents 1
using RgbImage = Image<std::array<std::uint8_t, 3>>;  // 255 represents 1

// Returns the bytes of the file: grey with 16 bits, or red, green and blue with 8 bits each.
// Requires width and height from 1 to 2^14 and width * height pixels. Source: PNG Specification,
// third edition (W3C, 2025), with the stored blocks of RFC 1951, section 3.2.4, in the wrapper of
// RFC 1950.
std::string encode_png(const GreyImage& image);
std::string encode_png(const RgbImage& image);

}  // namespace palpate
