#pragma once

// Renders a sine relief from an image and compares the force with the exact one, which is known in
// closed form. The comparison shows how the error depends on the size of a texel.

#include <cstddef>
#include <cstdint>

#include "engine/accuracy/knob.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {

// A slab whose top has the relief h(x) = H/2 (sin(2 pi x / L + phase) - 1). The relief comes from
// an image of one wave, which repeats. The hand slides along the top and is pressed in deeper than
// the relief is high.
struct SineRelief {
  double height_m = 3e-4;  // H, from the lowest to the highest point
  double wave_m = 0x1p-8;  // L, a power of two, so that no texture coordinate is rounded
  double stiffness_N_per_m = 1000.0;
  double period_s = 1e-3;
  // With this default, the hand moves less than a quarter of the finest texel per tick. Reliefs
  // fade out under faster motion.
  std::size_t ticks_per_wave = 600;
  std::size_t waves = 1;  // number of waves that the hand crosses

  double texel_m(int texels_per_wave) const { return wave_m / texels_per_wave; }
};

// The number of bits of a value in an image.
enum class ImageDepth { k8Bit, k16Bit };

// The largest rounding error of a height in the image, divided by the height of the relief. It is
// half a step of the image's integers.
double image_floor(ImageDepth depth);

// The scene with the slab. In the scene frame, the slab is centred at the origin and its top is at
// z = 2 L. Returns the errors of Scene::compile().
Result<Scene> sine_slab(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                        double phase_rad);

// Renders the slab along one path of the hand. Sample::error is the root mean square of the normal
// force minus K (d + h(x)), divided by K H: it has no unit. d is the depth of the hand below the
// slab's top, K is the stiffness. The seed determines the phase of the relief and the start and the
// direction of the hand.
Sample render_sine(const SineRelief& relief, int texels_per_wave, ImageDepth depth,
                   const Accuracy& accuracy, std::uint64_t seed);

}  // namespace palpate
