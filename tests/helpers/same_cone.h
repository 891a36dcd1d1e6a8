#pragma once

// Friction cones that are equal at every face.

#include "haptics/proxy/god_object.h"

namespace palpate::test {

struct SameCone final : FrictionCones {
  explicit SameCone(const FrictionCone& c) : cone(c) {}
  FrictionCone at(const FaceContact&, const Vec3&) noexcept override { return cone; }
  FrictionCone cone;
};

}  // namespace palpate::test
