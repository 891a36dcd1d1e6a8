#pragma once

// A relief known in closed form, felt by way of an image: what its texels cost.

#include <cstddef>
#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

// A slab whose top carries h(x) = H/2 (sin(2 pi x / L + phase) - 1), as an image of one wave that
// repeats. The hand goes along it, pressed in deeper than the relief.
struct SineRelief {
  double height_m = 3e-4;  // H, from the lowest to the highest point
  double wave_m = 0x1p-8;  // L, a power of two: then no texture coordinate is rounded
  double stiffness_N_per_m = 1000.0;
  double period_s = 1e-3;
  // Slower than a quarter of the finest texel a tick, from where on reliefs are blended out.
  std::size_t ticks_per_wave = 600;
  std::size_t waves = 1;  // that are felt

  double texel_m(int texels_per_wave) const { return wave_m / texels_per_wave; }
};

// Whole numbers that an image can hold: 2^bits.
enum class ImageDepth { k8Bit, k16Bit };

// What rounding a height to that image comes to, at most, over the height of the relief: half a
// step.
double image_floor(ImageDepth depth);

// The slab with the image of a wave, scene frame; its top is at two waves' height. Error: as of
// Scene::compile().
Result<Scene> sine_slab(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                        double phase_rad);

// Error: the normal force less K (d + h(x)), rms, over K H. No unit. The seed decides the phase,
// and where the hand begins and heads for.
Sample render_sine(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                   const Accuracy& accuracy, std::uint64_t seed);

}  // namespace palpate
