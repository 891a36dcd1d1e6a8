#pragma once

// Texture: relief from an image.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "geometry/mesh/height_map.h"
#include "haptics/effects/effect.h"

namespace palpate {

// A height map displaces the surface under the proxy along its normal (Ho, Basdogan and Srinivasan
// 1999, "Efficient point-based rendering techniques for haptic display of virtual objects"). With
// penetration depth d, height h <= 0 and slope grad h, the spring has the energy K (d + h)^2 / 2.
// The force is the exact gradient of this energy: K (d + h) (N - grad h). A closed loop therefore
// gains no energy, except through sampling in time. Mip levels (Williams 1983, "Pyramidal
// parametrics") remove waves that pass in a few ticks, before they can alias.
//
// At the value 1 of the map, the rendered surface is that of the mesh; at the value 0, it lies
// below that of the mesh by the texture's height. A texture only carves the surface, so that
// contact begins softly, at the surface of the mesh. Only the hand's speed selects the level; the
// texture of a moving body can therefore alias.
struct TextureEffect {
  static constexpr std::string_view kName = "texture";
  static constexpr EffectStage kStage = EffectStage::kSurface;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsVelocity | kNeedsTextureMap;

  // The texels of the selected level are at least this many times as long as the motion in a tick.
  // Averaging over such a texel removes the waves that pass in one or two ticks.
  static constexpr double kTexelsPerStep = 4.0;

  struct Parameters {
    double height_m = 0.0;
    const HeightMap* map = nullptr;  // values from 0 to 1
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"textureHeight", "m", 0.0, 1.0, offsetof(Parameters, height_m),
       ParameterKey::Role::kDeclares,
       "height difference between the lowest and the highest value of the map", true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  // Approximate log2 for x >= 1: exact at powers of two and linear between them, up to 0.09 too
  // low.
  static double rough_log2(double x) noexcept {
    constexpr double kPerBit = std::numeric_limits<double>::epsilon();
    constexpr double kBias = std::numeric_limits<double>::max_exponent - 1;
    // The bits of a double, as an integer, are its exponent followed by its mantissa.
    return kPerBit * static_cast<double>(std::bit_cast<std::int64_t>(x)) - kBias;
  }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    const FacePoint& face = tick.face;
    const UvMap& uv_map = face.attributes->texture_uv[face.slot];
    const auto& [grad_u, grad_v] = uv_map.gradient;
    const Vec3 step_body = face.body->displacement_to_body(tick.dt_s * tick.velocity_m_per_s);
    const double columns = kTexelsPerStep * p.map->width() * grad_u.dot(step_body);
    const double rows = kTexelsPerStep * p.map->height() * grad_v.dot(step_body);
    const double lod = 0.5 * rough_log2(std::max(1.0, columns * columns + rows * rows));
    const auto uv = uv_map.at(face.point_body);
    const HeightMap::Sample sample = p.map->sample(uv[0], uv[1], lod);
    // Interpolation may exceed the range of the map.
    tick.height_m = p.height_m * std::min(0.0, sample.value - 1.0);
    if (sample.value >= 1.0) return true;
    tick.slope =
        face.body->gradient_to_solver(p.height_m * (sample.d_du * grad_u + sample.d_dv * grad_v));
    return true;
  }
};

}  // namespace palpate
