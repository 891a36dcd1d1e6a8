#pragma once

// A relief known in closed form, rendered from an image: the accuracy that texels buy.

#include <cstddef>
#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

// A slab with the relief h(x) = H/2 (sin(2 pi x / L + phase) - 1) on its top, from a repeated image
// of one wave. The hand moves along it, pressed in deeper than the relief.
struct SineRelief {
  double height_m = 3e-4;  // H, from the lowest to the highest point
  double wave_m = 0x1p-8;  // L, a power of two, so that no texture coordinate is rounded
  double stiffness_N_per_m = 1000.0;
  double period_s = 1e-3;
  // Slower than a quarter of the finest texel per tick; faster motion fades reliefs out.
  std::size_t ticks_per_wave = 600;
  std::size_t waves = 1;  // that the hand crosses

  double texel_m(int texels_per_wave) const { return wave_m / texels_per_wave; }
};

// Bits of the integers in an image.
enum class ImageDepth { k8Bit, k16Bit };

// The largest rounding error of a height in the image, over the height of the relief: half a step.
double image_floor(ImageDepth depth);

// The slab with the image of a wave, scene frame; its top is at a height of two waves. An error as
// of Scene::compile().
Result<Scene> sine_slab(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                        double phase_rad);

// error: the normal force less K (d + h(x)), rms, over K H, without a unit. The seed determines the
// phase, and the start and the direction of the hand.
Sample render_sine(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                   const Accuracy& accuracy, std::uint64_t seed);

}  // namespace palpate
