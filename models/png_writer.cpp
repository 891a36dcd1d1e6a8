#include "models/png_writer.h"

#include <algorithm>
#include <cassert>
#include <zlib.h>

namespace palpate {
namespace {

// Constants of the specifications.
constexpr const char* kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::uint32_t kColourGrey = 0;
constexpr std::uint32_t kColourRgb = 2;
constexpr char kNoFilter = 0;
constexpr const char* kZlibHeader = "\x78\x01";  // deflate, 32 KiB window, fastest level
constexpr std::size_t kMaxStored = 0xffff;       // bytes of a stored block
constexpr std::size_t kMaxSide = std::size_t{1} << 14;

void append_big_endian(std::string& bytes, std::uint32_t value, int byte_count) {
  for (int i = byte_count; i-- > 0;) bytes += static_cast<char>(value >> 8 * i & 0xffu);
}

const Bytef* as_bytes(const std::string& bytes) {
  return reinterpret_cast<const Bytef*>(bytes.data());
}

std::string chunk(const std::string& type, const std::string& content) {
  const std::string checked = type + content;
  std::string bytes;
  append_big_endian(bytes, static_cast<std::uint32_t>(content.size()), 4);
  bytes += checked;
  const uLong sum = crc32_z(crc32_z(0, nullptr, 0), as_bytes(checked), checked.size());
  append_big_endian(bytes, static_cast<std::uint32_t>(sum), 4);
  return bytes;
}

// A stored block: one byte (1 in the last block), then the size and its complement, low byte first.
void append_block(std::string& bytes, const std::string& content, bool is_last) {
  bytes += static_cast<char>(is_last);
  for (const std::size_t word : {content.size(), ~content.size()}) {
    bytes += static_cast<char>(word & 0xffu);
    bytes += static_cast<char>(word >> 8 & 0xffu);
  }
  bytes += content;
}

std::string stored(const std::string& content) {
  std::string bytes = kZlibHeader;
  for (std::size_t at = 0; at < content.size(); at += kMaxStored) {
    append_block(bytes, content.substr(at, kMaxStored), at + kMaxStored >= content.size());
  }
  const uLong sum = adler32_z(adler32_z(0, nullptr, 0), as_bytes(content), content.size());
  append_big_endian(bytes, static_cast<std::uint32_t>(sum), 4);
  return bytes;
}

void append_pixel(std::string& row, std::uint16_t grey) {
  append_big_endian(row, grey, 2);
}

void append_pixel(std::string& row, const std::array<std::uint8_t, 3>& rgb) {
  for (const std::uint8_t value : rgb) append_big_endian(row, value, 1);
}

template <typename Pixel>
std::string encode(const Image<Pixel>& image, std::uint32_t bit_depth, std::uint32_t colour_type) {
  assert(image.width >= 1 && image.width <= kMaxSide);
  assert(image.height >= 1 && image.height <= kMaxSide);
  assert(image.pixels.size() == image.width * image.height);
  std::string header;
  append_big_endian(header, static_cast<std::uint32_t>(image.width), 4);
  append_big_endian(header, static_cast<std::uint32_t>(image.height), 4);
  // The compression and filter methods have only the value 0; no interlace.
  for (const std::uint32_t value : {bit_depth, colour_type, 0u, 0u, 0u}) {
    append_big_endian(header, value, 1);
  }
  std::string rows;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (i % image.width == 0) rows += kNoFilter;
    append_pixel(rows, image.pixels[i]);
  }
  return kSignature + chunk("IHDR", header) + chunk("IDAT", stored(rows)) + chunk("IEND", "");
}

}  // namespace

std::string encode_png(const GreyImage& image) {
  return encode(image, 16, kColourGrey);
}

std::string encode_png(const RgbImage& image) {
  return encode(image, 8, kColourRgb);
}

}  // namespace palpate
