#pragma once

// Fine relief from an image.

#include <algorithm>
#include <cmath>

#include "geometry/height_map.h"
#include "haptics/effects/effect.h"

namespace palpate {

// A height map moves the surface under the proxy (Ho, Basdogan and Srinivasan 1999, "Efficient
// point-based rendering techniques for haptic display of virtual objects": displacement along the
// normal and its gradient). With depth d, height h <= 0 and slope grad h, the spring has
// the energy K (d + h)^2 / 2, of which the force is the exact gradient: K (d + h) (N - grad h). So
// a texture gives nothing round a loop but what sampling in time makes of it: waves that pass in a
// few ticks are blended out by mip levels (Williams 1983, "Pyramidal parametrics") before they can
// alias. Value 1 of the map is the surface of the mesh, 0 lies `height` below it: a texture carves,
// so that contact begins where the proxy meets the mesh, and softly.
struct TextureEffect {
  static constexpr std::string_view kName = "texture";
  static constexpr EffectStage kStage = EffectStage::kSurface;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsVelocity | kNeedsTextureMap;

  // Texels of the level that is felt are at least so many times the way of one tick: of a wave
  // that passes in a tick or two, averaging over a texel leaves nothing.
  static constexpr double kTexelsPerStep = 2.0;

  struct Parameters {
    double height_m = 0.0;
    const HeightMap* map = nullptr;  // values from 0 to 1
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"textureHeight", "m", 0.0, 1.0, offsetof(Parameters, height_m),
       ParameterKey::Role::kCallsFor, "from the lowest to the highest value of the map", true}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    const FacePoint& face = tick.face;
    const CornerCoordinates& corners = face.attributes->texture_uv[face.slot];
    const TriangleGeometry& t = face.triangle();
    const Vec3 ab = t.b - t.a;
    const Vec3 ac = t.c - t.a;
    const double twice_area_m2 = triple_product(t.normal, ab, ac);
    if (!(twice_area_m2 > 0.0)) return false;
    // The gradient over the triangle of what grows by f along ab and by g along ac.
    const Vec3 along_ab = ac.cross(t.normal) / twice_area_m2;
    const Vec3 along_ac = t.normal.cross(ab) / twice_area_m2;
    const auto gradient = [&](std::size_t axis) -> Vec3 {
      return (corners[1][axis] - corners[0][axis]) * along_ab +
             (corners[2][axis] - corners[0][axis]) * along_ac;
    };
    const Vec3 grad_u = gradient(0);
    const Vec3 grad_v = gradient(1);
    const Vec3 step_body = face.body->direction_to_body(tick.dt_s * tick.velocity_m_per_s);
    const double texels = std::hypot(grad_u.dot(step_body) * p.map->width(),
                                     grad_v.dot(step_body) * p.map->height());
    const double lod = std::log2(std::max(1.0, kTexelsPerStep * texels));
    const auto uv = face.coordinates(corners);
    const HeightMap::Sample sample = p.map->sample(uv[0], uv[1], lod);
    // Interpolation may overshoot the values of the map.
    tick.height_m = p.height_m * std::min(0.0, sample.value - 1.0);
    if (sample.value >= 1.0) return true;
    tick.slope = face.body->direction_to_solver(
        p.height_m * (sample.d_du * grad_u + sample.d_dv * grad_v));
    return true;
  }
};

}  // namespace palpate
