#pragma once

// Friction: Coulomb's dry friction.

#include <algorithm>

#include "geometry/mesh/height_map.h"
#include "haptics/effects/effect.h"

namespace palpate {

// Coulomb's friction cone on the god-object (Harwin and Melder 2002, "Improved haptic rendering for
// multi-finger manipulation using friction cone based god-objects"), with memory. Let d be the
// penetration depth and t the tangential lag. A contact that sticks keeps its place while
// |t| <= mu_s d. Beyond this limit, it slides with |t| = mu_k d in every tick. When |t| falls below
// mu_k d, it sticks again. The contact does not creep at rest, and no speed affects it. If a device
// with mass is pulled slowly, the gap between mu_s and mu_k causes stick-slip. The coefficients are
// those of the material, and of the place in its map, that the proxy touches at the end of the
// tick.
//
// The god-object holds the proxy (GodObject::move_with_friction); this effect sets the
// coefficients. A map multiplies both of them.
struct FrictionEffect {
  static constexpr std::string_view kName = "friction";
  static constexpr EffectStage kStage = EffectStage::kProxy;
  static constexpr std::uint32_t kNeeds = kNeedsContact | kNeedsStickSlip | kNeedsFrictionMap;

  struct Parameters {
    double static_friction = 0.0;
    double dynamic_friction = 0.0;
    const HeightMap* map = nullptr;  // values in [0, 1]
  };
  struct State {};
  static constexpr ParameterKey kKeys[] = {
      {"staticFriction", "", 0.0, 1000.0, offsetof(Parameters, static_friction),
       ParameterKey::Role::kDeclares,
       "ratio of tangential to normal force at which sliding begins"},
      {"dynamicFriction", "", 0.0, 1000.0, offsetof(Parameters, dynamic_friction),
       ParameterKey::Role::kDeclares, "ratio of tangential to normal force while sliding"}};

  static const char* contradiction(const Parameters& p) noexcept {
    return p.dynamic_friction > p.static_friction ? "dynamicFriction is larger than staticFriction"
                                                  : nullptr;
  }

  static bool apply(const Parameters& p, State&, EffectTick& tick) noexcept {
    tick.cone = {p.static_friction, p.dynamic_friction};
    if (p.map) {
      const auto uv = tick.face.attributes->friction_uv[tick.face.slot].at(tick.face.point_body);
      const double part = std::clamp(p.map->value(uv[0], uv[1], 0.0), 0.0, 1.0);
      tick.cone.static_friction *= part;
      tick.cone.dynamic_friction *= part;
    }
    return tick.cone.holds();
  }
};

}  // namespace palpate
