#include "models/haptic_maps.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// The phase of the waves at the centre of a pixel.
double phase_rad(int pixel) {
  return 2.0 * std::numbers::pi * kMapWaves * (pixel + 0.5) / kMapSide;
}

// Calls value(column, row) for each pixel.
template <typename Pixel, typename Function>
Image<Pixel> map_of(Function value) {
  Image<Pixel> image{kMapSide, kMapSide, {}};
  for (int row = 0; row < kMapSide; ++row) {
    for (int column = 0; column < kMapSide; ++column) image.pixels.push_back(value(column, row));
  }
  return image;
}

std::uint16_t to_16_bit(double value) {
  return static_cast<std::uint16_t>(std::round(65535.0 * value));
}

std::uint8_t to_8_bit(double component) {
  return static_cast<std::uint8_t>(std::round(255.0 * (component + 1.0) / 2.0));
}

}  // namespace

GreyImage sine_height_map() {
  return map_of<std::uint16_t>(
      [](int column, int) { return to_16_bit(0.5 + 0.5 * std::sin(phase_rad(column))); });
}

GreyImage striped_friction_map(int count, double even, double odd) {
  assert(count > 0 && kMapSide % count == 0);
  assert(even >= 0.0 && even <= 1.0 && odd >= 0.0 && odd <= 1.0);
  return map_of<std::uint16_t>([=](int column, int) {
    return to_16_bit(column / (kMapSide / count) % 2 == 0 ? even : odd);
  });
}

RgbImage bump_normal_map(double height_ratio) {
  const double steepest = height_ratio * std::numbers::pi * kMapWaves;  // slope
  return map_of<std::array<std::uint8_t, 3>>([=](int column, int row) {
    const double u_rad = phase_rad(column);
    const double v_rad = phase_rad(row);
    const double x = -steepest * std::cos(u_rad) * std::sin(v_rad);
    const double y = steepest * std::sin(u_rad) * std::cos(v_rad);
    const double length = std::sqrt(x * x + y * y + 1.0);
    return std::array{to_8_bit(x / length), to_8_bit(y / length), to_8_bit(1.0 / length)};
  });
}

}  // namespace palpate
