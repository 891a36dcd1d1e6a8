#include "tests/helpers/png_writer.h"

#include <algorithm>
#include <cstddef>

namespace palpate::test {
namespace {

std::string big_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xffu);
  return text;
}

std::string little_endian16(std::uint32_t value) {
  return {static_cast<char>(value & 0xffu), static_cast<char>(value >> 8 & 0xffu)};
}

// PNG, annex D: the polynomial of ISO 3309, lowest bit first.
std::uint32_t crc32(const std::string& bytes) {
  constexpr std::uint32_t kPolynomial = 0xedb88320u;
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? kPolynomial : 0u);
  }
  return ~crc;
}

// RFC 1950, section 8.2.
std::uint32_t adler32(const std::string& bytes) {
  constexpr std::uint32_t kModulus = 65521;
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  for (const char c : bytes) {
    a = (a + static_cast<std::uint8_t>(c)) % kModulus;
    b = (b + a) % kModulus;
  }
  return b << 16 | a;
}

// RFC 1950 around RFC 1951, section 3.2.4.
std::string zlib_stored(const std::string& bytes) {
  constexpr std::size_t kMaxBlock = 65535;
  std::string stream = "\x78\x01";
  std::size_t begin = 0;
  do {
    const std::size_t size = std::min(kMaxBlock, bytes.size() - begin);
    const bool last = begin + size == bytes.size();
    stream += static_cast<char>(last);
    stream += little_endian16(static_cast<std::uint32_t>(size));
    stream += little_endian16(~static_cast<std::uint32_t>(size));
    stream += bytes.substr(begin, size);
    begin += size;
  } while (begin < bytes.size());
  return stream + big_endian(adler32(bytes), 4);
}

std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size()), 4) + type + data +
         big_endian(crc32(type + data), 4);
}

std::size_t channels_of(int colour_type) {
  switch (colour_type) {
    case 2:
      return 3;
    case 4:
      return 2;
    case 6:
      return 4;
    default:
      return 1;
  }
}

}  // namespace

std::string png_of(const PngLayout& layout, const std::vector<std::uint16_t>& samples) {
  const std::size_t row = channels_of(layout.colour_type) * layout.width;
  std::string data;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % row == 0) data += '\0';  // filter type 0: none
    data += big_endian(samples[i], layout.bit_depth / 8);
  }
  const std::string header = big_endian(layout.width, 4) + big_endian(layout.height, 4) +
                             static_cast<char>(layout.bit_depth) +
                             static_cast<char>(layout.colour_type) + std::string(3, '\0');
  std::string file = "\x89PNG\r\n\x1a\n" + chunk("IHDR", header);
  if (layout.colour_type == 3) {
    file += chunk("PLTE", std::string("\x10\0\0\x20\0\0\x30\0\0\x40\0\0", 12));
  }
  return file + chunk("IDAT", zlib_stored(data)) + chunk("IEND", "");
}

}  // namespace palpate::test
