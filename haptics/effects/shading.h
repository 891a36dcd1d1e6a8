#pragma once

// Facets that are felt as a smooth surface.

#include <limits>

#include "haptics/effects/effect.h"

namespace palpate {

// Force shading (Morgenbesser and Srinivasan 1996, "Force shading for haptic shape perception"):
// the force is turned from the facet's normal to one interpolated between the corners,
// n = sum w_i n_i / |sum w_i n_i|, w the barycentric weights of the proxy, as Phong does with
// light. The magnitude stays that of the facets. Corners on edges sharper than the crease angle
// keep the normals of either side, so that creases stay. A force that is turned is no gradient of
// anything: round a loop it can give K d^2 times the angle between the normals, about.
struct ShadingEffect {
  static constexpr std::string_view kName = "shading";
  static constexpr EffectStage kStage = EffectStage::kSurface;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsCornerNormals;

  // Corner normals that differ from the facet's by no more than their rounding to float: a flat
  // face is felt as without shading, to the bit.
  static constexpr double kFlat = 2.0 * std::numeric_limits<float>::epsilon();

  struct Parameters {
    double crease_angle_deg = 0.0;  // baked into the corner normals
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"creaseAngle", "deg", 0.0, 180.0, offsetof(Parameters, crease_angle_deg),
       ParameterKey::Role::kCallsFor, "edges sharper than this angle remain creases"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters&, State&, EffectTick& tick) noexcept {
    TriangleGeometry room;
    const TriangleGeometry& facet = tick.face.triangle(room);
    const auto w = tick.face.barycentric(facet);
    const CornerNormals& normals = tick.face.attributes->corner_normals[tick.face.slot];
    Vec3 smooth_body = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      smooth_body += w[i] * Vec3(normals[i][0], normals[i][1], normals[i][2]);
    }
    const double length = smooth_body.norm();
    if (!(length > 0.0)) return false;
    smooth_body /= length;
    if ((smooth_body - facet.normal).squaredNorm() <= kFlat * kFlat) return false;
    const Vec3 front = tick.face.body->direction_to_solver(smooth_body);
    // The proxy may be at the back of the face.
    const double along = front.dot(tick.normal);
    if (along == 0.0) return false;
    tick.rendered_normal = along < 0.0 ? Vec3(-front) : front;
    return true;
  }
};

}  // namespace palpate
