#pragma once

// Reconstructs the heights of a surface from its normal map.
//
// Rows are counted from the top and columns from the left, as in an image. Lengths are in texels,
// which are assumed to be square. Load time only: the functions allocate. Thread-safe.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate {

// The slope of a map per texel: {along a row to the right, down a column}. No unit.
using TexelSlope = std::array<float, 2>;

// The lower limit for the z component of a normal: one step of an eight-bit texture. A smaller z,
// which should not occur in a tangent-space map, is raised to this limit. A slope is therefore at
// most 127.5 |scale|.
inline constexpr double kLeastNormalZ = 2.0 / 255.0;

// The slopes of a tangent-space normal map of glTF 2.0: a texel's normal is n = 2 c / 65535 - 1 for
// its red, green and blue values c. x and y are multiplied by `scale`
// (material.normalTexture.scale, finite), and z is at least kLeastNormalZ. The normal need not have
// length 1. +X points to the right and +Y up, opposite to the order of rows, so the slopes are
// {-n_x / n_z, n_y / n_z}.
//
// Eight bits cannot represent a flat map exactly: the value 128 of 255 has an offset of 0.004. The
// offset does not affect the heights, because heights_from_slopes() drops the mean slope.
std::vector<TexelSlope> slopes_from_normal_map(std::span<const std::array<std::uint16_t, 3>> pixels,
                                               double scale);

// The heights, in texels, of the periodic map whose slopes are the least-squares fit to the given
// slopes (R. T. Frankot and R. Chellappa, "A Method for Enforcing Integrability in Shape from
// Shading Algorithms", 1988, eq. 21). The highest point has the height 0. Slopes are the
// derivatives of the trigonometric polynomial through the heights, not differences of neighbours.
// The map of a sampled surface is therefore reconstructed exactly if all its waves are longer than
// two texels. A wave of exactly two texels is omitted, because its slope is zero at every sample.
// The mean slope is omitted too, because the mean slope of a periodic map is zero. A constant slope
// therefore gives heights of exactly zero.
//
// slopes: row by row, finite. Requires width * height slopes, with width and height from 1 to 2^28
// (checked by asserts). O(n log n) time for n texels, for any factors of width and height, and 16
// bytes of temporary memory per texel.
std::vector<float> heights_from_slopes(std::uint32_t width, std::uint32_t height,
                                       std::span<const TexelSlope> slopes);

}  // namespace palpate
