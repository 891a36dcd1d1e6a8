#pragma once

// Images with haptic values for the effect scenes. Each image repeats without a seam. Pixel (i, j)
// of an image with n pixels per side has the texture coordinates ((i + 0.5) / n, (j + 0.5) / n),
// with j downwards. The images are identical on every platform: the sines of two platforms may
// differ in their last bit, but the rounded pixels do not. Thread-safe.

#include "models/png_writer.h"

namespace palpate {

inline constexpr int kMapSide = 64;  // pixels per side of each image
inline constexpr int kMapWaves = 4;  // waves of the sine and of the bumps along a side

// Heights 1/2 + 1/2 sin(2 pi kMapWaves u), constant along v. 0 is the lowest height, 65535 the
// highest.
GreyImage sine_height_map();

// Coefficients of friction in `count` stripes along u, alternating between `even` and `odd`. The
// value 65535 is a coefficient of 1. Requires kMapSide to be a multiple of count and both
// coefficients in [0, 1].
GreyImage striped_friction_map(int count, double even, double odd);

// The normals of the heights height_ratio / 2 (1 + sin(2 pi kMapWaves u) sin(2 pi kMapWaves v)),
// where height_ratio is the height from the lowest to the highest point divided by the image's
// side. The encoding is glTF's (2.0, section 3.9.3): x to the right, y up (opposite to v), z
// outward; a component c in [-1, 1] is stored as 255 (c + 1) / 2, rounded.
RgbImage bump_normal_map(double height_ratio);

}  // namespace palpate
