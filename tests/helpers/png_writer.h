#pragma once

// Small PNG files for tests, valid or not, written without a library: the data are stored without
// compression.

#include <cstdint>
#include <string>
#include <vector>

namespace palpate::test {

struct PngLayout {
  std::uint32_t width = 1;
  std::uint32_t height = 1;
  int bit_depth = 8;    // 8 or 16
  int colour_type = 2;  // 0 grey, 2 RGB, 3 palette of four reds, 4 grey and alpha, 6 RGB and alpha
};

// samples: pixel by pixel from the top, with as many numbers per pixel as the colour type has
// channels; there may be fewer than the size requires.
std::string png_of(const PngLayout& layout, const std::vector<std::uint16_t>& samples);

}  // namespace palpate::test
