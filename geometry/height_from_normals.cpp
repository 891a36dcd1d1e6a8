#include "geometry/height_from_normals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <utility>

namespace palpate {
namespace {

using Complex = std::complex<double>;

// A two-dimensional array, row by row, and its discrete Fourier transform in place.
class Plane {
 public:
  Plane(std::size_t width, std::size_t height)
      : width_(width), height_(height), values_(width * height) {}

  Complex& at(std::size_t row, std::size_t column) { return values_[row * width_ + column]; }
  std::vector<Complex>& values() { return values_; }

  void transform(bool inverse) {
    for (std::size_t row = 0; row < height_; ++row) {
      transform_line(&values_[row * width_], width_, 1, inverse);
    }
    for (std::size_t column = 0; column < width_; ++column) {
      transform_line(&values_[column], height_, width_, inverse);
    }
  }

 private:
  void transform_line(Complex* line, std::size_t size, std::size_t stride, bool inverse) {
    if (size == 1) return;
    before_.resize(size);
    after_.resize(size);
    for (std::size_t i = 0; i < size; ++i) before_[i] = line[i * stride];
    const auto count = static_cast<Eigen::Index>(size);
    if (inverse) {
      fft_.inv(after_.data(), before_.data(), count);
    } else {
      fft_.fwd(after_.data(), before_.data(), count);
    }
    for (std::size_t i = 0; i < size; ++i) line[i * stride] = after_[i];
  }

  std::size_t width_, height_;
  std::vector<Complex> values_;
  std::vector<Complex> before_, after_;
  Eigen::FFT<double> fft_;
};

// What differentiating multiplies coefficient k of a line by, over i. For the wave of two texels it
// is 0: its slope vanishes at every sample.
double frequency(std::size_t k, std::size_t size) {
  if (2 * k == size) return 0.0;
  const double turns = 2 * k < size ? static_cast<double>(k) : -static_cast<double>(size - k);
  return 2.0 * std::numbers::pi * turns / static_cast<double>(size);
}

// Coefficients of the heights, from those of p + i q for the slopes p along rows and q along
// columns. With f and g the coefficients of p + i q at frequencies w and -w, those of p and q at w
// are (f + g*) / 2 and (f - g*) / 2i; put in eq. 21, -i (w_x P + w_y Q) / |w|^2.
Complex height_coefficient(Complex f, Complex g, double w_x, double w_y) {
  const double squared = w_x * w_x + w_y * w_y;
  if (squared == 0.0) return 0.0;
  const Complex p = 0.5 * (f + std::conj(g));
  const Complex q = Complex(0.0, -0.5) * (f - std::conj(g));
  return Complex(0.0, -1.0) * (w_x * p + w_y * q) / squared;
}

}  // namespace

std::vector<TexelSlope> slopes_from_normal_map(std::span<const std::array<std::uint16_t, 3>> pixels,
                                               double scale) {
  constexpr double kStep = 2.0 / std::numeric_limits<std::uint16_t>::max();
  std::vector<TexelSlope> slopes;
  slopes.reserve(pixels.size());
  for (const std::array<std::uint16_t, 3>& pixel : pixels) {
    const double per_z = scale / std::max(kStep * pixel[2] - 1.0, kLeastNormalZ);
    slopes.push_back({static_cast<float>((1.0 - kStep * pixel[0]) * per_z),
                      static_cast<float>((kStep * pixel[1] - 1.0) * per_z)});
  }
  return slopes;
}

std::vector<float> heights_from_slopes(std::uint32_t width, std::uint32_t height,
                                       std::span<const TexelSlope> slopes) {
  [[maybe_unused]] constexpr std::uint32_t kMostTexels = std::numeric_limits<int>::max();
  assert(width >= 1 && height >= 1 && width <= kMostTexels && height <= kMostTexels);
  assert(slopes.size() == std::size_t{width} * height);
  Plane plane(width, height);
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    plane.values()[i] = Complex(slopes[i][0], slopes[i][1]);
  }
  plane.transform(false);
  for (std::size_t row = 0; row < height; ++row) {
    const double w_y = frequency(row, height);
    for (std::size_t column = 0; column < width; ++column) {
      const std::size_t opposite_row = row == 0 ? 0 : height - row;
      const std::size_t opposite_column = column == 0 ? 0 : width - column;
      // Each pair once: the coefficients of a real map at opposite frequencies are conjugate.
      if (std::pair(opposite_row, opposite_column) < std::pair(row, column)) continue;
      Complex& f = plane.at(row, column);
      Complex& g = plane.at(opposite_row, opposite_column);
      f = height_coefficient(f, g, frequency(column, width), w_y);
      g = std::conj(f);
    }
  }
  plane.transform(true);
  double highest = -std::numeric_limits<double>::infinity();
  for (const Complex& value : plane.values()) highest = std::max(highest, value.real());
  std::vector<float> heights;
  heights.reserve(slopes.size());
  for (const Complex& value : plane.values()) {
    heights.push_back(static_cast<float>(value.real() - highest));
  }
  return heights;
}

}  // namespace palpate
