#pragma once

// Provides the god-object with the friction coefficients that a world's effects set for its faces.

#include "haptics/effects/effect_runner.h"
#include "haptics/proxy/friction_cone.h"

namespace palpate {

// Both references must outlive the object.
class ConesOfEffects final : public FrictionCones {
 public:
  ConesOfEffects(EffectRunner& effects, const LiveWorld& world)
      : effects_(effects), world_(world) {}
  FrictionCone at(const FaceContact& contact, const Vec3& proxy) noexcept override {
    return effects_.friction_cone(world_, contact, proxy);
  }

 private:
  EffectRunner& effects_;
  const LiveWorld& world_;
};

}  // namespace palpate
