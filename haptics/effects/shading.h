#pragma once

// Shading: facets are rendered as a smooth surface.

#include <limits>

#include "haptics/effects/effect.h"

namespace palpate {

// Force shading (Morgenbesser and Srinivasan 1996, "Force shading for haptic shape perception")
// turns the force from the facet's normal to an interpolated normal n, as Phong shading does for
// light. n = sum w_i n_i / |sum w_i n_i|, with n_i the normals of the corners and w_i the
// barycentric weights of the proxy. The magnitude of the force remains that of the facets. Corners
// at edges sharper than the crease angle have a normal for each side, so that creases remain.
//
// A turned force is not the gradient of a potential: a closed loop can gain an energy of about
// K d^2 times the angle between the normals, at penetration depth d.
struct ShadingEffect {
  static constexpr std::string_view kName = "shading";
  static constexpr EffectStage kStage = EffectStage::kSurface;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsCornerNormals;

  // A smooth normal is ignored if it differs from the facet's normal by at most this value, which
  // the rounding to float can cause. The force of a flat face is therefore the same to the bit with
  // and without shading.
  static constexpr double kFlat = 2.0 * std::numeric_limits<float>::epsilon();

  struct Parameters {
    double crease_angle_deg = 0.0;  // already applied in the corner normals
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"creaseAngle", "deg", 0.0, 180.0, offsetof(Parameters, crease_angle_deg),
       ParameterKey::Role::kDeclares, "edges sharper than this angle remain creases"}};

  static const char* contradiction(const Parameters&) noexcept { return nullptr; }

  static bool apply(const Parameters&, State&, EffectTick& tick) noexcept {
    TriangleGeometry storage;
    const TriangleGeometry& facet = tick.face.triangle(storage);
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
