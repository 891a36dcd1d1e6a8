#pragma once

// What a proxy touches, and where it is stopped.

#include <compare>
#include <cstdint>

#include "geometry/exact/triangle.h"
#include "haptics/proxy/triangle_trace.h"

namespace palpate {

// Names one triangle of the world.
struct FaceRef {
  std::uint32_t body = 0;
  std::uint32_t slot = 0;  // of the body's index
  friend bool operator==(const FaceRef&, const FaceRef&) = default;
  friend auto operator<=>(const FaceRef&, const FaceRef&) = default;
};

// A contact plane of a face at some proxy position. Solver frame, metres.
struct FaceContact {
  FaceRef face;
  Vec3 normal;         // unit, from the surface to the proxy
  double clearance_m;  // of the proxy's surface above the face, along the normal
  TriangleFeature feature = TriangleFeature::kFace;
  Vec3 feature_point;  // the point touched
};

// Where a step is stopped.
struct TraceHit {
  FaceContact contact;                                 // at the stopping point
  StepFraction fraction = StepFraction::start();       // up to which the step may be taken
  StepFraction meet_fraction = StepFraction::start();  // where they would meet, >= fraction
};

}  // namespace palpate
