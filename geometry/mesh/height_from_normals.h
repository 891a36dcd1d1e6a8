#pragma once

// Heights for maps that only tell normals.
//
// Rows count from the top and columns from the left, as in an image; lengths are in texels, which
// are taken as square. Load time only: these allocate. Thread-safe.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate {

// How a map rises per texel: {along a row to the right, down a column}. No unit.
using TexelSlope = std::array<float, 2>;

// The least z that a normal is given: one step of an eight-bit texture. What a map says below that
// (in a tangent space map nothing should be) counts as a slope of 127.5 at most, times |scale|.
inline constexpr double kLeastNormalZ = 2.0 / 255.0;

// The slopes of a tangent-space normal map of glTF 2.0: a texel's normal is n = 2 c / 65535 - 1 of
// its red, green and blue c, x and y times `scale` (material.normalTexture.scale, finite), and z at
// least kLeastNormalZ; it need not have length 1. +X points to the right and +Y up, against the
// rows, so the slopes are {-n_x / n_z, n_y / n_z}.
//
// Eight bits cannot encode a level map: 128 of 255 is 0.004 off. A height map made of the slopes
// does not show it, since heights_from_slopes() drops what is the same everywhere.
std::vector<TexelSlope> slopes_from_normal_map(std::span<const std::array<std::uint16_t, 3>> pixels,
                                               double scale);

// The heights of the periodic map whose slopes are nearest to the given ones in the least-squares
// sense, in texels, the highest at 0: R. T. Frankot and R. Chellappa, "A Method for Enforcing
// Integrability in Shape from Shading Algorithms", 1988, eq. 21. Slopes are the derivatives of the
// trigonometric polynomial through the heights, not differences of neighbours: the map of a sampled
// surface comes back exactly if it has no waves shorter than two texels. Of a wave of just two
// texels, samples of the slope say nothing; it is left out, and so is the mean slope, which no
// periodic map has; the same slope everywhere gives zeros, without rounding.
//
// slopes: row by row, finite, width * height of them, width and height from 1 to 2^28 (checked by
// asserts). Takes n log n time for n texels, whatever the factors of width and height, and 16 bytes
// a texel meanwhile.
std::vector<float> heights_from_slopes(std::uint32_t width, std::uint32_t height,
                                       std::span<const TexelSlope> slopes);

}  // namespace palpate
