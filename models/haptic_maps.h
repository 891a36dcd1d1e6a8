#pragma once

// Images that hold haptic values, for the scenes of effects. Each repeats without a seam. Pixel
// (i, j) of an image of n pixels a side stands for the place ((i + 0.5) / n, (j + 0.5) / n) of its
// texture coordinates, j downwards. The same on every platform: sines may differ in their last bit,
// no rounded pixel does. Thread-safe.

#include "models/png_writer.h"

namespace palpate {

inline constexpr int kMapSide = 64;  // pixels, of each image
inline constexpr int kMapWaves = 4;  // of the sine and of the bumps, along a side

// Heights 1/2 + 1/2 sin(2 pi kMapWaves u), the same along v; 0 is the lowest and 65535 the highest.
GreyImage sine_height_map();

// Coefficients of friction, 65535 being 1: `even` and `odd` in turn, in `count` stripes along u.
// Requires kMapSide to be a multiple of count, and both coefficients within 0 and 1.
GreyImage striped_friction_map(int count, double even, double odd);

// The normals of the heights height_ratio / 2 (1 + sin(2 pi kMapWaves u) sin(2 pi kMapWaves v)),
// height_ratio being the height from the lowest to the highest point in lengths of the image's
// side. As glTF has them (2.0, section 3.9.3): x to the right, y up (against v), z outward; a
// component c in [-1, 1] is stored as 255 (c + 1) / 2, rounded.
RgbImage bump_normal_map(double height_ratio);

}  // namespace palpate
