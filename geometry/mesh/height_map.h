#pragma once

// A scalar map over texture coordinates with a mip pyramid, smooth enough for haptic rendering.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// The continuation of a map outside [0, 1], as in glTF's samplers.
enum class MapWrap : std::uint8_t { kRepeat, kClamp, kMirror };

// A map given by values at the centres of texels. The centre of a texel has the texture coordinates
// (u, v) = ((column + 0.5) / width, (row + 0.5) / height), with v downwards as in glTF.
//
// Within a level the map is the cubic convolution with a = -1/2 (R. G. Keys, "Cubic Convolution
// Interpolation for Digital Image Processing", 1981), which is the Catmull-Rom spline. It passes
// through the values of the texels, and value and slope are continuous everywhere, including the
// borders of the map. The slopes are the exact derivatives of the interpolant. For a sine wave of n
// texels, n large, the error of the value is (2pi/n)^3 / 62 of the amplitude, and the error of the
// slope is (2pi/n)^2 / 6 of the largest slope.
//
// Each level halves width and height, rounded down, until 1 x 1. A texel is the mean of the box
// that it covers in the finer level, weighted by area if the size is odd. Every level therefore has
// the mean of the map, up to rounding to float. Between levels the map is blended linearly (L.
// Williams, "Pyramidal Parametrics", 1983). The coarsest level is flat.
//
// The pyramid prevents aliasing. Aliasing can occur because a hand samples a map only once per
// tick. A wave that is shorter than a few steps of the hand would be rendered as an alias: as a
// slower wave that the map does not contain, or as noise. A caller removes such waves by choosing a
// lod at which one texel is at least as long as the step: lod = log2 of the step in texels.
//
// Immutable after build; sampling is thread-safe and safe on the haptic thread: no allocation, lock
// or exception.
class HeightMap {
 public:
  // values: row by row from the top, in the caller's unit, finite. Requires width, height >= 1 and
  // width * height values (checked by asserts: a reader must reject other maps). Linear time.
  static HeightMap build(std::uint32_t width, std::uint32_t height, std::vector<float> values,
                         MapWrap wrap_u, MapWrap wrap_v);

  struct Sample {
    double value;       // the caller's unit
    double d_du, d_dv;  // the same unit per unit of texture coordinate
  };

  // lod: 0 is the finest level and levels() - 1 the coarsest; other values are clamped to this
  // range. A whole number reads one level, any other value two. u and v may have any finite value.
  // If u, v or lod is NaN, or u or v is infinite, the result is the mean with zero slope.
  Sample sample(double u, double v, double lod) const noexcept;
  // The same value as sample(), bit for bit.
  double value(double u, double v, double lod) const noexcept;

  std::uint32_t width() const { return levels_.front().width; }
  std::uint32_t height() const { return levels_.front().height; }
  int levels() const { return static_cast<int>(levels_.size()); }
  double mean() const { return mean_; }
  std::size_t memory_bytes() const;

 private:
  // The number of extra texels beyond each border, so that the sixteen texels around a point are
  // always four runs of four.
  static constexpr std::uint32_t kBorder = 2;

  struct Level {
    std::uint32_t width = 0, height = 0;
    std::size_t first = 0;  // index of the upper left texel, border included
    std::size_t stride() const { return std::size_t{width} + 2 * kBorder; }
    std::size_t size() const { return stride() * (std::size_t{height} + 2 * kBorder); }
  };

  // The position of a coordinate among the texels of a level.
  struct Place {
    std::uint32_t tap = 0;  // the first of four, counted from the border
    double t = 0.0;         // from the second tap to the third, in [0, 1]
    double sense = 1.0;     // -1 where the map is mirrored
  };
  static Place place(double coordinate, std::uint32_t size, MapWrap wrap) noexcept;

  void add_level(std::uint32_t width, std::uint32_t height, const std::vector<float>& values);
  template <bool kSlopes>
  Sample sample_level(const Level& level, double u, double v) const noexcept;
  template <bool kSlopes>
  Sample sample_levels(double u, double v, double lod) const noexcept;

  std::vector<Level> levels_;
  std::vector<float> texels_;
  MapWrap wrap_u_ = MapWrap::kRepeat;
  MapWrap wrap_v_ = MapWrap::kRepeat;
  double mean_ = 0.0;
};

}  // namespace palpate
