#pragma once

// A scalar map over texture coordinates, with a mip pyramid, smooth enough to be felt.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// What a map shows outside [0, 1], as the samplers of glTF have it.
enum class MapWrap : std::uint8_t { kRepeat, kClamp, kMirror };

// Values at the centres of texels, ((column + 0.5) / width, (row + 0.5) / height) for texture
// coordinates (u, v) as in glTF: v grows downwards.
//
// Within a level the map is the cubic convolution with a = -1/2 (R. G. Keys, "Cubic Convolution
// Interpolation for Digital Image Processing", 1981; the Catmull-Rom spline): it passes
// through the texels, and value and slope are continuous everywhere, also across the borders of the
// map. The slopes are those of the very interpolant. For long waves of n texels the error is
// (2 pi / n)^3 / 62 of the amplitude, and that of the slope (2 pi / n)^2 / 6 of the steepest.
//
// Levels halve width and height, rounded down, to 1 x 1; a texel is the mean of the box below it,
// weighted by area where the size is odd, so every level has the mean of the map up to rounding to
// float. Between levels the map is blended linearly (L. Williams, "Pyramidal Parametrics", 1983).
// The coarsest level is flat.
//
// The pyramid is there because a hand samples a map once a tick. Where a wave is shorter than a few
// steps from one tick to the next, what it renders is an alias: a slower wave that the map does not
// have, or noise. A caller chooses lod so that such waves are gone: one texel of the level at least
// as long as the step, log2 of the step in texels.
//
// Immutable after build; sampling is thread-safe and safe on the haptic thread: no allocation, lock
// or exception.
class HeightMap {
 public:
  // values: row by row from the top, in the caller's unit, finite. Requires width, height >= 1 and
  // width * height values (checked by asserts: a reader must have refused such a map before).
  // Linear time.
  static HeightMap build(std::uint32_t width, std::uint32_t height, std::vector<float> values,
                         MapWrap wrap_u, MapWrap wrap_v);

  struct Sample {
    double value;       // the caller's unit
    double d_du, d_dv;  // the same unit per unit of texture coordinate
  };

  // lod: 0 is the finest level, levels() - 1 the coarsest; what lies outside is clamped. Between
  // whole numbers two levels are read, else one. u and v may be as large as they like; where u, v
  // or lod is not a number, or u or v infinite, the answer is the mean without slope.
  Sample sample(double u, double v, double lod) const noexcept;
  // The value of sample(), to the bit.
  double value(double u, double v, double lod) const noexcept;

  std::uint32_t width() const { return levels_.front().width; }
  std::uint32_t height() const { return levels_.front().height; }
  int levels() const { return static_cast<int>(levels_.size()); }
  double mean() const { return mean_; }
  std::size_t memory_bytes() const;

 private:
  // Texels a level has beyond each border, so that the sixteen around a point are always four runs
  // of four.
  static constexpr std::uint32_t kBorder = 2;

  struct Level {
    std::uint32_t width = 0, height = 0;
    std::size_t first = 0;  // of its texels, the border's upper left one
    std::size_t stride() const { return std::size_t{width} + 2 * kBorder; }
    std::size_t size() const { return stride() * (std::size_t{height} + 2 * kBorder); }
  };

  // Where a coordinate lies among the texels of a level.
  struct Place {
    std::uint32_t tap = 0;  // the first of four, counted from the border
    double t = 0.0;         // from the second tap to the third, in [0, 1]
    double sense = 1.0;     // -1 where the map is shown reversed
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
