#include "geometry/mesh/height_from_normals.h"

#include <algorithm>
#include <bit>
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

// The largest prime factor of a size that is transformed directly. A direct transform takes p
// multiplications per value for each prime factor p. A chirp transform takes as many
// multiplications per value as a factor of 30 to 60, fewer with less padding.
constexpr std::size_t kLargestDirectFactor = 31;

// The largest size for which the chirp transform has a plan: the key of the plan, twice the size,
// is an int.
[[maybe_unused]] constexpr std::uint32_t kMostAlong = std::uint32_t{1} << 28;

std::size_t largest_prime_factor(std::size_t n) {
  std::size_t largest = 1;
  for (std::size_t p = 2; p * p <= n; ++p) {
    while (n % p == 0) {
      largest = p;
      n /= p;
    }
  }
  return std::max(largest, n);
}

// The discrete Fourier transform of lines of one size n, in O(n log n) for any n. A size with a
// large prime factor is computed as a convolution by transforms of a power of two: L. Bluestein, "A
// Linear Filtering Approach to the Computation of Discrete Fourier Transform", 1970. From 2 j k =
// j^2 + k^2 - (k - j)^2 follows, with the chirp c_k = exp(-i pi k^2 / n),
//
//   X_k = sum_j x_j exp(-2 pi i j k / n) = c_k sum_j (x_j c_j) c*_(k-j)
class LineTransform {
 public:
  explicit LineTransform(std::size_t size) : size_(size) {
    if (largest_prime_factor(size) <= kLargestDirectFactor) return;
    chirp_.resize(size);
    before_.assign(std::bit_ceil(2 * size - 1), 0.0);
    for (std::size_t k = 0; k < size; ++k) {
      // A full turn is k^2 = 2 n. The angle keeps all digits because k^2 is reduced modulo 2 n.
      const auto squares = static_cast<double>(k * k % (2 * size));
      chirp_[k] = std::polar(1.0, -std::numbers::pi * squares / static_cast<double>(size));
      before_[k] = std::conj(chirp_[k]);
      if (k > 0) before_[before_.size() - k] = before_[k];
    }
    filter_.resize(before_.size());
    forward(before_, filter_);
  }

  // In place. Requires a line of the transform's size.
  void transform(std::vector<Complex>& line) {
    if (size_ == 1) return;
    if (chirp_.empty()) {
      after_.resize(size_);
      forward(line, after_);
      line.swap(after_);
      return;
    }
    before_.assign(filter_.size(), 0.0);
    after_.resize(filter_.size());
    for (std::size_t k = 0; k < size_; ++k) before_[k] = line[k] * chirp_[k];
    forward(before_, after_);
    for (std::size_t k = 0; k < filter_.size(); ++k) after_[k] *= filter_[k];
    fft_.inv(before_.data(), after_.data(), static_cast<Eigen::Index>(after_.size()));
    for (std::size_t k = 0; k < size_; ++k) line[k] = before_[k] * chirp_[k];
  }

 private:
  void forward(const std::vector<Complex>& from, std::vector<Complex>& to) {
    fft_.fwd(to.data(), from.data(), static_cast<Eigen::Index>(from.size()));
  }

  std::size_t size_;
  std::vector<Complex> chirp_;   // empty: the size is transformed directly
  std::vector<Complex> filter_;  // transform of the conjugate chirp, periodic in a power of two
  std::vector<Complex> before_, after_;
  Eigen::FFT<double> fft_;
};

// A two-dimensional array, row by row, and its discrete Fourier transform in place.
class Plane {
 public:
  Plane(std::size_t width, std::size_t height)
      : width_(width), height_(height), values_(width * height) {}

  Complex& at(std::size_t row, std::size_t column) { return values_[row * width_ + column]; }
  std::vector<Complex>& values() { return values_; }

  void transform() {
    transform_lines(height_, width_, width_, 1);
    transform_lines(width_, 1, height_, width_);
  }

 private:
  // Consecutive lines start `apart` values from each other; consecutive values of a line are
  // `stride` apart.
  void transform_lines(std::size_t count, std::size_t apart, std::size_t size, std::size_t stride) {
    LineTransform of_line(size);
    std::vector<Complex> line(size);
    for (std::size_t n = 0; n < count; ++n) {
      Complex* const first = &values_[n * apart];
      for (std::size_t i = 0; i < size; ++i) line[i] = first[i * stride];
      of_line.transform(line);
      for (std::size_t i = 0; i < size; ++i) first[i * stride] = line[i];
    }
  }

  std::size_t width_, height_;
  std::vector<Complex> values_;
};

// The factor of differentiation for coefficient k of a line, divided by i. The factor is 0 for a
// wave of two texels, because its slope is zero at every sample.
double frequency(std::size_t k, std::size_t size) {
  if (2 * k == size) return 0.0;
  const double turns = 2 * k < size ? static_cast<double>(k) : -static_cast<double>(size - k);
  return 2.0 * std::numbers::pi * turns / static_cast<double>(size);
}

// The coefficient of the heights from the coefficients of p + i q, where p are the slopes along
// rows and q along columns. If f and g are the coefficients of p + i q at frequencies w and -w, the
// coefficients of p and q at w are P = (f + g*) / 2 and Q = (f - g*) / 2i. Eq. 21 then gives -i
// (w_x P + w_y Q) / |w|^2.
Complex height_coefficient(Complex f, Complex g, double w_x, double w_y) {
  const double squared = w_x * w_x + w_y * w_y;
  if (squared == 0.0) return 0.0;
  const Complex p = 0.5 * (f + std::conj(g));
  const Complex q = Complex(0.0, -0.5) * (f - std::conj(g));
  return Complex(0.0, -1.0) * (w_x * p + w_y * q) / squared;
}

// The mean of p + i q. Exact for up to 2^29 texels if all slopes are equal, because a double can
// hold their sum.
Complex mean_slope(std::span<const TexelSlope> slopes) {
  Complex sum;
  for (const TexelSlope& slope : slopes) sum += Complex(slope[0], slope[1]);
  return sum / static_cast<double>(slopes.size());
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
  assert(width >= 1 && height >= 1 && width <= kMostAlong && height <= kMostAlong);
  assert(slopes.size() == std::size_t{width} * height);
  const Complex mean = mean_slope(slopes);
  Plane plane(width, height);
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    plane.values()[i] = Complex(slopes[i][0], slopes[i][1]) - mean;
  }
  plane.transform();
  for (std::size_t row = 0; row < height; ++row) {
    const double w_y = frequency(row, height);
    for (std::size_t column = 0; column < width; ++column) {
      const std::size_t opposite_row = row == 0 ? 0 : height - row;
      const std::size_t opposite_column = column == 0 ? 0 : width - column;
      // Each pair of opposite frequencies is computed once: the coefficients of a real map are
      // conjugate.
      if (std::pair(opposite_row, opposite_column) < std::pair(row, column)) continue;
      Complex& f = plane.at(row, column);
      Complex& g = plane.at(opposite_row, opposite_column);
      // Exchanged, so that the forward transform acts as the inverse, up to the factor of the
      // number of texels.
      g = height_coefficient(f, g, frequency(column, width), w_y);
      f = std::conj(g);
    }
  }
  plane.transform();
  double highest = -std::numeric_limits<double>::infinity();
  for (const Complex& value : plane.values()) highest = std::max(highest, value.real());
  std::vector<float> heights;
  heights.reserve(slopes.size());
  for (const Complex& value : plane.values()) {
    heights.push_back(
        static_cast<float>((value.real() - highest) / static_cast<double>(slopes.size())));
  }
  return heights;
}

}  // namespace palpate
