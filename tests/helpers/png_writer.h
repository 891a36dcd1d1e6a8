#pragma once

// Small PNG files for tests, right or wrong, made without a library: their data are stored, not
// compressed.

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

// samples: pixel by pixel from the top, as many for each as the colour type has; they may be fewer
// than the size asks for.
std::string png_of(const PngLayout& layout, const std::vector<std::uint16_t>& samples);

}  // namespace palpate::test
