#include "geometry/mesh/height_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/mesh/height_from_normals.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kFloatRoundoff;
using test::Random;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::array kWraps = {MapWrap::kRepeat, MapWrap::kClamp, MapWrap::kMirror};

template <typename Function>
std::vector<float> texels(std::uint32_t width, std::uint32_t height, Function at_centre) {
  std::vector<float> values;
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      values.push_back(static_cast<float>(at_centre((column + 0.5) / width, (row + 0.5) / height)));
    }
  }
  return values;
}

HeightMap random_height_map(Random& random, std::uint32_t width, std::uint32_t height,
                            MapWrap wrap_u, MapWrap wrap_v) {
  return HeightMap::build(
      width, height, texels(width, height, [&](double, double) { return random.uniform(-1, 1); }),
      wrap_u, wrap_v);
}

// A map of `size` texels with two waves along u and one along v.
HeightMap wave_map(std::uint32_t size) {
  return HeightMap::build(
      size, size,
      texels(size, size,
             [](double u, double v) { return std::sin(2 * kTurn * u) + std::sin(kTurn * v); }),
      MapWrap::kRepeat, MapWrap::kRepeat);
}

// Error bounds for sin(x) with step h, plus 5 percent for higher orders. Hermite's cubic with exact
// slopes has an error of h^4 f'''' / 384, and sqrt(3) h^3 f'''' / 216 in the slope. Central
// differences have an error of h^2 f''' / 6. This error contributes with the factor t (1 - t)(1 - 2
// t) h, at most h / (6 sqrt 3), to the value, and with the factor 1 to the slope.
double value_bound(double h) {
  return 1.05 * (h * h * h / (36.0 * std::sqrt(3.0)) + h * h * h * h / 384.0);
}
double slope_bound(double h) {
  return 1.05 * (h * h / 6.0 + std::sqrt(3.0) * h * h * h / 216.0);
}

TEST(HeightMap, ApproximatesASineToThirdOrderAndItsSlopeToSecond) {
  Random random(501);
  double value_before = 0.0;
  double slope_before = 0.0;
  for (const std::uint32_t size : {16u, 32u, 64u, 128u}) {
    const HeightMap map = wave_map(size);
    const double h_u = 2 * kTurn / size;
    const double h_v = kTurn / size;
    double value_error = 0.0;
    double slope_error = 0.0;
    for (int trial = 0; trial < 4000; ++trial) {
      const double u = random.uniform(-2, 2);
      const double v = random.uniform(-2, 2);
      const HeightMap::Sample sample = map.sample(u, v, 0.0);
      value_error = std::max(
          value_error, std::abs(sample.value - std::sin(2 * kTurn * u) - std::sin(kTurn * v)));
      slope_error =
          std::max(slope_error, std::abs(sample.d_du / (2 * kTurn) - std::cos(2 * kTurn * u)));
      ASSERT_NEAR(sample.d_dv / kTurn, std::cos(kTurn * v),
                  slope_bound(h_v) + 8 * kFloatRoundoff / h_v);
    }
    EXPECT_LT(value_error, value_bound(h_u) + value_bound(h_v) + 8 * kFloatRoundoff);
    EXPECT_LT(slope_error, slope_bound(h_u) + 8 * kFloatRoundoff / h_u);
    if (value_before > 0.0) {
      EXPECT_LT(value_error, value_before / 7.0) << size;
      EXPECT_LT(slope_error, slope_before / 3.5) << size;
    }
    value_before = value_error;
    slope_before = slope_error;
  }
}

TEST(HeightMap, InterpolatesItsTexelsFromTheTopLeft) {
  const std::vector<float> values = {1, 2, 3, 40, 50, 60};
  for (const MapWrap wrap : kWraps) {
    const HeightMap map = HeightMap::build(3, 2, values, wrap, wrap);
    for (std::size_t i = 0; i < 6; ++i) {
      const double u = (static_cast<double>(i % 3) + 0.5) / 3.0;
      const double v = (static_cast<double>(i / 3) + 0.5) / 2.0;
      EXPECT_NEAR(map.value(u, v, 0.0), values[i], 1e-13 * 60);
    }
  }
}

TEST(HeightMap, ReturnsTheDerivativesOfItsValues) {
  Random random(502);
  for (const MapWrap wrap_u : kWraps) {
    for (const MapWrap wrap_v : kWraps) {
      const HeightMap map = random_height_map(random, 13, 6, wrap_u, wrap_v);
      for (int trial = 0; trial < 500; ++trial) {
        const double u = random.uniform(-3, 3);
        const double v = random.uniform(-3, 3);
        const double lod = random.uniform(-0.5, 3.5);
        const HeightMap::Sample sample = map.sample(u, v, lod);
        EXPECT_EQ(sample.value, map.value(u, v, lod));
        const double step = 1e-6;
        const double du = (map.value(u + step, v, lod) - map.value(u - step, v, lod)) / (2 * step);
        const double dv = (map.value(u, v + step, lod) - map.value(u, v - step, lod)) / (2 * step);
        // The second derivative, which jumps at texels, is at most 13^2 * 16.
        const double bound = 13 * 13 * 16 * step;
        ASSERT_NEAR(sample.d_du, du, bound) << u << ' ' << v << ' ' << lod;
        ASSERT_NEAR(sample.d_dv, dv, bound) << u << ' ' << v << ' ' << lod;
      }
    }
  }
}

TEST(HeightMap, IsSmoothAcrossTexelsAndBorders) {
  Random random(503);
  for (const MapWrap wrap : kWraps) {
    const std::uint32_t width = 5;
    const std::uint32_t height = 4;
    const HeightMap map = random_height_map(random, width, height, wrap, wrap);
    // Half texels: centres, borders, and the point beyond which a clamped map is constant.
    for (int i = -24; i <= 24; ++i) {
      const double step = 1e-12;
      const double elsewhere = random.uniform(-1, 1);
      for (const double lod : {0.0, 0.7, 1.0}) {
        const double u = 0.5 * i / width;
        HeightMap::Sample before = map.sample(u - step, elsewhere, lod);
        HeightMap::Sample after = map.sample(u + step, elsewhere, lod);
        // Slopes are at most 5 * 4, second derivatives 5^2 * 16.
        EXPECT_NEAR(before.value, after.value, 2 * step * 20);
        EXPECT_NEAR(before.d_du, after.d_du, 2 * step * 400 + 1e-13);
        EXPECT_NEAR(before.d_dv, after.d_dv, 2 * step * 400 + 1e-13);
        const double v = 0.5 * i / height;
        before = map.sample(elsewhere, v - step, lod);
        after = map.sample(elsewhere, v + step, lod);
        EXPECT_NEAR(before.value, after.value, 2 * step * 20);
        EXPECT_NEAR(before.d_du, after.d_du, 2 * step * 400 + 1e-13);
        EXPECT_NEAR(before.d_dv, after.d_dv, 2 * step * 400 + 1e-13);
      }
    }
  }
}

TEST(HeightMap, RepeatsClampsOrMirrorsOutside) {
  Random random(504);
  const HeightMap repeated = random_height_map(random, 7, 5, MapWrap::kRepeat, MapWrap::kRepeat);
  const HeightMap clamped = random_height_map(random, 7, 5, MapWrap::kClamp, MapWrap::kClamp);
  const HeightMap mirrored = random_height_map(random, 7, 5, MapWrap::kMirror, MapWrap::kMirror);
  for (int trial = 0; trial < 500; ++trial) {
    const double u = random.uniform(0, 1);
    const double v = random.uniform(0, 1);
    const double lod = random.uniform(0, 2);
    EXPECT_NEAR(repeated.value(u + 3, v - 2, lod), repeated.value(u, v, lod), 1e-13);
    EXPECT_NEAR(mirrored.value(-u, v, lod), mirrored.value(u, v, lod), 1e-13);
    EXPECT_NEAR(mirrored.value(2 - u, v + 4, lod), mirrored.value(u, v, lod), 1e-13);
    EXPECT_NEAR(mirrored.sample(-u, 2 - v, lod).d_du, -mirrored.sample(u, v, lod).d_du, 1e-12);
    EXPECT_NEAR(mirrored.sample(-u, 2 - v, lod).d_dv, -mirrored.sample(u, v, lod).d_dv, 1e-12);
    // At the centres of the first and last texels, and beyond the next half texel.
    const double beyond = 1.0 + 0.5 / 3.0 + random.uniform(0, 10);
    const double whole_lod = lod < 1.0 ? 0.0 : 1.0;
    const HeightMap::Sample right = clamped.sample(beyond, v, whole_lod);
    EXPECT_NEAR(right.value, clamped.value(1e300, v, whole_lod), 1e-15);
    EXPECT_EQ(right.d_du, 0.0);
  }
  const HeightMap step = HeightMap::build(2, 1, {-1, 1}, MapWrap::kClamp, MapWrap::kClamp);
  EXPECT_EQ(step.value(-9, 0.5, 0), -1.0);
  EXPECT_EQ(step.value(9, 0.5, 0), 1.0);
  EXPECT_EQ(step.value(0.5, 9, 0), 0.0);
}

TEST(HeightMap, KeepsTheMeanOnEveryLevelOfAnySize) {
  Random random(505);
  for (int trial = 0; trial < 60; ++trial) {
    const auto width = static_cast<std::uint32_t>(1 + random.index(40));
    const auto height = static_cast<std::uint32_t>(1 + random.index(40));
    double mean = 0.0;
    std::vector<float> values = texels(
        width, height, [&](double u, double v) { return random.uniform(-1, 1) + 3 * u * u - v; });
    for (const float value : values) mean += value;
    mean /= static_cast<double>(values.size());
    const HeightMap map =
        HeightMap::build(width, height, values, MapWrap::kClamp, MapWrap::kRepeat);
    std::uint32_t w = width;
    std::uint32_t h = height;
    for (int level = 0; level < map.levels(); ++level) {
      double sum = 0.0;
      for (std::uint32_t row = 0; row < h; ++row) {
        for (std::uint32_t column = 0; column < w; ++column) {
          sum += map.value((column + 0.5) / w, (row + 0.5) / h, level);
        }
      }
      // Each level rounds twice to float.
      EXPECT_NEAR(sum / w / h, mean, (2 * level + 1) * kFloatRoundoff * 5)
          << width << " x " << height;
      if (level + 1 == map.levels()) {
        EXPECT_EQ(w * h, 1u);
      }
      w = std::max(1u, w / 2);
      h = std::max(1u, h / 2);
    }
    EXPECT_NEAR(map.mean(), mean, 2 * map.levels() * kFloatRoundoff * 5);
    const HeightMap::Sample coarsest = map.sample(0.3, 0.4, 1e9);
    EXPECT_EQ(coarsest.value, map.mean());
    EXPECT_EQ(coarsest.d_du, 0.0);
    EXPECT_EQ(coarsest.d_dv, 0.0);
  }
}

TEST(HeightMap, WeighsTexelsOfOddSizesByArea) {
  // From 5 texels to 2: each covers two and a half.
  const HeightMap five =
      HeightMap::build(5, 1, {10, 20, 30, 40, 50}, MapWrap::kClamp, MapWrap::kClamp);
  EXPECT_EQ(five.levels(), 3);
  EXPECT_FLOAT_EQ(static_cast<float>(five.value(0.25, 0, 1)), (10 + 20 + 15) / 2.5f);
  EXPECT_FLOAT_EQ(static_cast<float>(five.value(0.75, 0, 1)), (15 + 40 + 50) / 2.5f);
  const HeightMap tall = HeightMap::build(1, 3, {1, 2, 6}, MapWrap::kRepeat, MapWrap::kMirror);
  EXPECT_EQ(tall.levels(), 2);
  EXPECT_EQ(tall.value(0.7, 0.1, 1), 3.0);
}

TEST(HeightMap, BlendsLevelsAndClampsThem) {
  Random random(506);
  const HeightMap map = random_height_map(random, 16, 16, MapWrap::kRepeat, MapWrap::kRepeat);
  EXPECT_EQ(map.levels(), 5);
  for (int trial = 0; trial < 200; ++trial) {
    const double u = random.uniform(0, 1);
    const double v = random.uniform(0, 1);
    const HeightMap::Sample low = map.sample(u, v, 1);
    const HeightMap::Sample high = map.sample(u, v, 2);
    const HeightMap::Sample between = map.sample(u, v, 1.25);
    EXPECT_NEAR(between.value, 0.75 * low.value + 0.25 * high.value, 1e-15);
    EXPECT_NEAR(between.d_du, 0.75 * low.d_du + 0.25 * high.d_du, 1e-13);
    EXPECT_NEAR(between.d_dv, 0.75 * low.d_dv + 0.25 * high.d_dv, 1e-13);
    EXPECT_EQ(map.value(u, v, -7), map.value(u, v, 0));
    EXPECT_EQ(map.value(u, v, 99), map.value(u, v, 4));
  }
}

// The mean over a box of n texels removes a wave of n texels, and scales a wave of 2 n texels by 2
// / pi.
TEST(HeightMap, RemovesWavesShorterThanATexelOfTheLevel) {
  const std::uint32_t size = 256;
  const HeightMap map = HeightMap::build(
      size, 1, texels(size, 1, [&](double u, double) { return std::sin(kTurn * u * size / 8); }),
      MapWrap::kRepeat, MapWrap::kRepeat);
  double finest = 0.0;
  for (int i = 0; i < 997; ++i) {
    const double u = i / 997.0;
    finest = std::max(finest, std::abs(map.value(u, 0, 0)));
    for (double lod = 3; lod < 9; lod += 0.5) {
      const HeightMap::Sample sample = map.sample(u, 0, lod);
      EXPECT_NEAR(sample.value, 0.0, 4 * kFloatRoundoff);
      EXPECT_NEAR(sample.d_du, 0.0, 64 * 4 * kFloatRoundoff);
    }
  }
  EXPECT_GT(finest, 0.99);
}

TEST(HeightMap, AcceptsAnyCoordinates) {
  Random random(507);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kMost = std::numeric_limits<double>::max();
  for (const MapWrap wrap : kWraps) {
    for (const std::uint32_t width : {1u, 2u, 3u, 9u}) {
      const HeightMap map = random_height_map(random, width, 3, wrap, wrap);
      // The absolute values of the Catmull-Rom weights in one direction add up to 1.25 at most.
      const double most = 1.25 * 1.25;
      for (const double far : {1e9 + 0.3, 1e18, 1e300, kMost, 5e-324, 1e-17}) {
        for (const double u : {far, -far}) {
          for (const double lod : {0.0, 0.5, kInfinity, -kInfinity}) {
            for (const HeightMap::Sample& s : {map.sample(u, 0.2, lod), map.sample(0.2, u, lod)}) {
              EXPECT_LE(std::abs(s.value), most);
              EXPECT_LE(std::abs(s.d_du), 4.0 * width);
              EXPECT_LE(std::abs(s.d_dv), 4.0 * 3);
            }
          }
        }
      }
      for (const double u : {kInfinity, -kInfinity, kNan}) {
        for (const HeightMap::Sample& s : {map.sample(u, 0.2, 0), map.sample(0.2, u, 0.5)}) {
          EXPECT_EQ(s.value, map.mean());
          EXPECT_EQ(s.d_du, 0.0);
          EXPECT_EQ(s.d_dv, 0.0);
        }
        EXPECT_EQ(map.value(u, u, 0), map.mean());
      }
      EXPECT_EQ(map.value(0.1, 0.2, kNan), map.mean());
    }
  }
}

TEST(HeightMap, UsesAThirdMoreMemoryThanItsTexels) {
  const HeightMap map = HeightMap::build(512, 512, std::vector<float>(512 * 512, 1.0f),
                                         MapWrap::kRepeat, MapWrap::kRepeat);
  const double texel_bytes = 512.0 * 512 * sizeof(float);
  EXPECT_GT(static_cast<double>(map.memory_bytes()), 4.0 / 3.0 * texel_bytes);
  EXPECT_LT(static_cast<double>(map.memory_bytes()), 1.4 * texel_bytes);
}

// ---- Heights from normals

// A periodic surface in texels and its slopes.
struct Waves {
  double amplitude;  // texels
  int across, down;  // waves per map
  std::uint32_t width, height;

  double w_x() const { return kTurn * across / width; }
  double w_y() const { return kTurn * down / height; }
  double at(double column, double row) const {
    return amplitude * std::sin(w_x() * column + 0.3) * std::cos(w_y() * row - 0.7);
  }
  TexelSlope slope(double column, double row) const {
    const double x = w_x() * column + 0.3;
    const double y = w_y() * row - 0.7;
    return {static_cast<float>(amplitude * w_x() * std::cos(x) * std::cos(y)),
            static_cast<float>(-amplitude * w_y() * std::sin(x) * std::sin(y))};
  }
};

template <typename Function>
auto per_texel(const Waves& waves, Function function) {
  std::vector<decltype(function(0.0, 0.0))> all;
  for (std::uint32_t row = 0; row < waves.height; ++row) {
    for (std::uint32_t column = 0; column < waves.width; ++column) {
      all.push_back(function(column, row));
    }
  }
  return all;
}

std::vector<double> expected_heights(const Waves& waves) {
  std::vector<double> heights =
      per_texel(waves, [&](double column, double row) { return waves.at(column, row); });
  const double highest = *std::max_element(heights.begin(), heights.end());
  for (double& height : heights) height -= highest;
  return heights;
}

const std::array<Waves, 11> kWaves = {{{1.0, 1, 0, 32, 32},
                                       {2.0, 0, 3, 32, 16},
                                       {0.5, 3, 2, 48, 31},
                                       {5.0, 2, 5, 45, 60},
                                       {1e-3, 7, 1, 17, 23},
                                       {1e3, 1, 1, 64, 7},
                                       {1.0, 4, 0, 37, 1},
                                       {1.0, 0, 4, 1, 50},
                                       {2.0, 5, 3, 127, 131},
                                       {1.0, 2, 9, 2 * 37, 3 * 41},
                                       {1.0, 1, 2, 1009, 1}}};

TEST(HeightsFromSlopes, ReconstructWavesFromTheirSlopes) {
  for (const Waves& waves : kWaves) {
    const std::vector<TexelSlope> slopes =
        per_texel(waves, [&](double column, double row) { return waves.slope(column, row); });
    const std::vector<float> heights = heights_from_slopes(waves.width, waves.height, slopes);
    const std::vector<double> expected = expected_heights(waves);
    ASSERT_EQ(heights.size(), expected.size());
    EXPECT_EQ(*std::max_element(heights.begin(), heights.end()), 0.0f);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      ASSERT_NEAR(heights[i], expected[i], 1e-6 * waves.amplitude) << i << ' ' << waves.width;
    }
  }
}

// A million texels with two prime sides. With one multiplication per texel of the line, this test
// would take many times as long as all other tests together.
TEST(HeightsFromSlopes, AcceptLargePrimeSizes) {
  const Waves waves{2.0, 3, 7, 1021, 1021};
  const std::vector<float> heights = heights_from_slopes(
      waves.width, waves.height,
      per_texel(waves, [&](double column, double row) { return waves.slope(column, row); }));
  const std::vector<double> expected = expected_heights(waves);
  double error = 0.0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    error = std::max(error, std::abs(heights[i] - expected[i]));
  }
  EXPECT_LE(error, 1e-6 * waves.amplitude);
}

// Exactly zero, because a later stretch of the heights to 0 .. 1 would amplify any rounding.
TEST(HeightsFromSlopes, AreZeroForAConstantSlope) {
  for (const auto& [width, height] : {std::pair(64u, 64u), {127u, 131u}, {45u, 49u}, {1u, 61u}}) {
    const std::vector<TexelSlope> slopes(std::size_t{width} * height, {0.0039215f, -0.7f});
    for (const float h : heights_from_slopes(width, height, slopes)) ASSERT_EQ(h, 0.0f) << width;
  }
}

TEST(HeightsFromSlopes, ReadANormalMapOfWaves) {
  for (const Waves& waves : kWaves) {
    const double scale = 0.25;
    const auto pixels = per_texel(waves, [&](double column, double row) {
      const TexelSlope slope = waves.slope(column, row);
      // The encoding of a renderer: y up, unit length, without the scale.
      const std::array<double, 3> n = {-slope[0] / scale, slope[1] / scale, 1.0};
      const double length = std::hypot(n[0], n[1], n[2]);
      std::array<std::uint16_t, 3> pixel;
      for (std::size_t k = 0; k < 3; ++k) {
        pixel[k] = static_cast<std::uint16_t>(std::lround((n[k] / length + 1.0) * 32767.5));
      }
      return pixel;
    });
    const double steepest = waves.amplitude * std::hypot(waves.w_x(), waves.w_y());
    if (steepest / scale > 20.0) continue;  // z would have too few digits
    const std::vector<TexelSlope> slopes = slopes_from_normal_map(pixels, scale);
    // Half a step of x, y and z, over z.
    const double z = 1.0 / std::hypot(1.0, steepest / scale);
    const double slope_error = (scale + steepest) / 65535.0 / z * 1.1;
    for (std::size_t i = 0; i < slopes.size(); ++i) {
      const auto column = static_cast<double>(i % waves.width);
      const auto row = static_cast<double>(i / waves.width);
      ASSERT_NEAR(slopes[i][0], waves.slope(column, row)[0], slope_error);
      ASSERT_NEAR(slopes[i][1], waves.slope(column, row)[1], slope_error);
    }
    const std::vector<float> heights = heights_from_slopes(waves.width, waves.height, slopes);
    const std::vector<double> expected = expected_heights(waves);
    // The height of a wave is its slope divided by the frequency. The lowest frequency is one turn
    // per map.
    const double bound = slope_error * std::max(waves.width, waves.height) / kTurn * 2.0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      ASSERT_NEAR(heights[i], expected[i], bound) << i << ' ' << waves.width;
    }
  }
}

TEST(HeightsFromSlopes, FitASurfaceToSlopesWithoutASurface) {
  // Adding a divergence-free field and a constant slope does not change the heights: both are
  // orthogonal to the slopes of every periodic surface.
  const Waves waves = kWaves[2];
  const Waves stream{3.0, 2, 4, waves.width, waves.height};
  const std::vector<TexelSlope> slopes = per_texel(waves, [&](double column, double row) {
    const TexelSlope own = waves.slope(column, row);
    const TexelSlope along = stream.slope(column, row);
    return TexelSlope{own[0] - along[1] + 0.5f, own[1] + along[0] - 0.25f};
  });
  const std::vector<float> heights = heights_from_slopes(waves.width, waves.height, slopes);
  const std::vector<double> expected = expected_heights(waves);
  for (std::size_t i = 0; i < heights.size(); ++i) ASSERT_NEAR(heights[i], expected[i], 3e-6);
}

TEST(HeightsFromSlopes, OmitAWaveOfTwoTexels) {
  std::vector<TexelSlope> slopes;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 6; ++column) {
      slopes.push_back({column % 2 == 0 ? 1.0f : -1.0f, row % 2 == 0 ? 1.0f : -1.0f});
    }
  }
  for (const float height : heights_from_slopes(6, 4, slopes)) EXPECT_NEAR(height, 0.0, 1e-15);
  EXPECT_EQ(heights_from_slopes(1, 1, std::vector<TexelSlope>{{3.0f, 4.0f}}),
            std::vector<float>{0.0f});
}

TEST(HeightsFromSlopes, ReconstructAWaveOfTwoTexelsInOneDirectionFromTheOther) {
  const double w = kTurn / 10;
  const auto at = [&](int column, int row) {
    return (column % 2 == 0 ? 1 : -1) * std::sin(w * row);
  };
  std::vector<TexelSlope> slopes;
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 8; ++column) {
      slopes.push_back({0.0f, static_cast<float>((column % 2 == 0 ? w : -w) * std::cos(w * row))});
    }
  }
  const std::vector<float> heights = heights_from_slopes(8, 10, slopes);
  for (int i = 0; i < 80; ++i) {
    EXPECT_NEAR(heights[static_cast<std::size_t>(i)] - heights[0], at(i % 8, i / 8), 1e-6);
  }
}

TEST(SlopesFromNormalMap, AreBoundedForEveryNormal) {
  const std::vector<std::array<std::uint16_t, 3>> pixels = {
      {65535, 0, 0}, {0, 65535, 32767}, {65535, 65535, 65535}, {32896, 32896, 65535}};
  const std::vector<TexelSlope> slopes = slopes_from_normal_map(pixels, 2.0);
  EXPECT_FLOAT_EQ(slopes[0][0], -255.0f);  // leans right, so it falls to the right
  EXPECT_FLOAT_EQ(slopes[0][1], -255.0f);  // leans down the rows
  EXPECT_FLOAT_EQ(slopes[1][0], 255.0f);
  EXPECT_FLOAT_EQ(slopes[1][1], 255.0f);
  EXPECT_FLOAT_EQ(slopes[2][0], -2.0f);
  EXPECT_FLOAT_EQ(slopes[2][1], 2.0f);
  EXPECT_NEAR(slopes[3][0], -2.0 / 255.0, 1e-8);
}

}  // namespace
}  // namespace palpate
