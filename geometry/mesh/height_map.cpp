#include "geometry/mesh/height_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

// The texel for index i, which may lie outside the map.
std::size_t wrapped(std::int64_t i, std::int64_t size, MapWrap wrap) {
  if (wrap == MapWrap::kClamp)
    return static_cast<std::size_t>(std::clamp<std::int64_t>(i, 0, size - 1));
  const std::int64_t period = wrap == MapWrap::kMirror ? 2 * size : size;
  i = (i % period + period) % period;
  return static_cast<std::size_t>(i < size ? i : period - 1 - i);
}

// Halves a line: each of the `half` results is the mean of the part of the line that it covers.
// Consecutive values of the line are `stride` apart.
void halve(const float* line, std::size_t size, std::size_t stride, std::size_t half, float* halved,
           std::size_t halved_stride) {
  const std::size_t odd = size - 2 * half;  // 0 or 1; in units of 1 / half of a texel
  for (std::size_t i = 0; i < half; ++i) {
    // From texel 2 i + i odd / half to 2 (i + 1) + (i + 1) odd / half.
    const float* const texel = line + 2 * i * stride;
    double sum = static_cast<double>((half - i * odd)) * texel[0] +
                 static_cast<double>(half) * texel[stride];
    if (odd != 0) sum += static_cast<double>(i + 1) * texel[2 * stride];
    halved[i * halved_stride] = static_cast<float>(sum / static_cast<double>(size));
  }
}

// Weights of the values at -1, 0, 1, 2 for the interpolant at t in [0, 1], and for its slope.
struct Weights {
  std::array<double, 4> value;
  std::array<double, 4> slope;
};

std::array<double, 4> value_weights(double t) {
  const double s = 1.0 - t;
  return {-0.5 * t * s * s, 1.0 + t * t * (1.5 * t - 2.5), 1.0 + s * s * (1.5 * s - 2.5),
          -0.5 * s * t * t};
}

std::array<double, 4> slope_weights(double t) {
  const double s = 1.0 - t;
  return {s * (1.5 * t - 0.5), t * (4.5 * t - 5.0), s * (5.0 - 4.5 * s), t * (0.5 - 1.5 * s)};
}

double dot(const std::array<double, 4>& weights, const float* values) {
  return (weights[0] * values[0] + weights[1] * values[1]) +
         (weights[2] * values[2] + weights[3] * values[3]);
}

double dot(const std::array<double, 4>& weights, const std::array<double, 4>& values) {
  return (weights[0] * values[0] + weights[1] * values[1]) +
         (weights[2] * values[2] + weights[3] * values[3]);
}

}  // namespace

HeightMap HeightMap::build(std::uint32_t width, std::uint32_t height, std::vector<float> values,
                           MapWrap wrap_u, MapWrap wrap_v) {
  assert(width >= 1 && height >= 1);
  assert(values.size() == std::size_t{width} * height);
  HeightMap map;
  map.wrap_u_ = wrap_u;
  map.wrap_v_ = wrap_v;
  map.add_level(width, height, values);
  std::vector<float> narrow;
  while (width > 1 || height > 1) {
    const std::uint32_t half_width = std::max(1u, width / 2);
    const std::uint32_t half_height = std::max(1u, height / 2);
    narrow.resize(std::size_t{half_width} * height);
    for (std::size_t row = 0; row < height; ++row) {
      const float* const line = &values[row * width];
      float* const halved = &narrow[row * half_width];
      if (width == 1)
        *halved = *line;
      else
        halve(line, width, 1, half_width, halved, 1);
    }
    values.resize(std::size_t{half_width} * half_height);
    for (std::size_t column = 0; column < half_width; ++column) {
      if (height == 1)
        values[column] = narrow[column];
      else
        halve(&narrow[column], height, half_width, half_height, &values[column], half_width);
    }
    width = half_width;
    height = half_height;
    map.add_level(width, height, values);
  }
  map.mean_ = values.front();
  map.texels_.shrink_to_fit();
  return map;
}

void HeightMap::add_level(std::uint32_t width, std::uint32_t height,
                          const std::vector<float>& values) {
  Level level{width, height, texels_.size()};
  texels_.resize(level.first + level.size());
  float* texel = &texels_[level.first];
  const std::int64_t border = kBorder;
  for (std::int64_t row = -border; row < height + border; ++row) {
    const float* const line = &values[wrapped(row, height, wrap_v_) * width];
    for (std::int64_t column = -border; column < width + border; ++column) {
      *texel++ = line[wrapped(column, width, wrap_u_)];
    }
  }
  levels_.push_back(level);
}

std::size_t HeightMap::memory_bytes() const {
  return sizeof(*this) + levels_.capacity() * sizeof(Level) + texels_.capacity() * sizeof(float);
}

// In every branch, x (in texels from the centre of the first texel) is between -1 and size, which
// the border covers.
HeightMap::Place HeightMap::place(double coordinate, std::uint32_t size, MapWrap wrap) noexcept {
  double sense = 1.0;
  double x = 0.0;
  if (wrap == MapWrap::kClamp) {
    // The interpolant is constant beyond half a texel outside the map.
    x = std::clamp(coordinate * size - 0.5, -1.0, static_cast<double>(size));
  } else if (wrap == MapWrap::kMirror) {
    double folded = coordinate - 2.0 * std::floor(0.5 * coordinate);
    if (folded > 1.0) {
      folded = 2.0 - folded;
      sense = -1.0;
    }
    x = folded * size - 0.5;
  } else {
    x = (coordinate - std::floor(coordinate)) * size - 0.5;
  }
  // The last taps also cover the end of the range.
  const double second = std::min(std::floor(x), static_cast<double>(size) - 1.0);
  return {static_cast<std::uint32_t>(static_cast<std::int64_t>(second) + (kBorder - 1)), x - second,
          sense};
}

template <bool kSlopes>
HeightMap::Sample HeightMap::sample_level(const Level& level, double u, double v) const noexcept {
  if (level.width == 1 && level.height == 1) return {mean_, 0.0, 0.0};
  const Place column = place(u, level.width, wrap_u_);
  const Place row = place(v, level.height, wrap_v_);
  const std::array<double, 4> across = value_weights(column.t);
  const std::array<double, 4> down = value_weights(row.t);
  const float* taps = &texels_[level.first + row.tap * level.stride() + column.tap];
  const std::array<const float*, 4> lines = {taps, taps + level.stride(), taps + 2 * level.stride(),
                                             taps + 3 * level.stride()};
  std::array<double, 4> values;
  for (std::size_t i = 0; i < 4; ++i) values[i] = dot(across, lines[i]);
  Sample sample{dot(down, values), 0.0, 0.0};
  if constexpr (kSlopes) {
    const std::array<double, 4> across_slope = slope_weights(column.t);
    std::array<double, 4> slopes;
    for (std::size_t i = 0; i < 4; ++i) slopes[i] = dot(across_slope, lines[i]);
    sample.d_du = column.sense * level.width * dot(down, slopes);
    sample.d_dv = row.sense * level.height * dot(slope_weights(row.t), values);
  }
  return sample;
}

template <bool kSlopes>
HeightMap::Sample HeightMap::sample_levels(double u, double v, double lod) const noexcept {
  const double coarsest = static_cast<double>(levels_.size() - 1);
  if (!std::isfinite(u) || !std::isfinite(v) || std::isnan(lod)) return {mean_, 0.0, 0.0};
  lod = std::clamp(lod, 0.0, coarsest);
  const auto finer = static_cast<std::size_t>(lod);
  const double blend = lod - static_cast<double>(finer);
  const Sample fine = sample_level<kSlopes>(levels_[finer], u, v);
  if (blend == 0.0) return fine;
  const Sample coarse = sample_level<kSlopes>(levels_[finer + 1], u, v);
  return {fine.value + blend * (coarse.value - fine.value),
          fine.d_du + blend * (coarse.d_du - fine.d_du),
          fine.d_dv + blend * (coarse.d_dv - fine.d_dv)};
}

HeightMap::Sample HeightMap::sample(double u, double v, double lod) const noexcept {
  return sample_levels<true>(u, v, lod);
}

double HeightMap::value(double u, double v, double lod) const noexcept {
  return sample_levels<false>(u, v, lod).value;
}

}  // namespace palpate
