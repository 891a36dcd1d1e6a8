#pragma once

// The contact of a proxy with a triangle, and the hit that stops a step.

#include <compare>
#include <cstdint>

#include "geometry/exact/triangle.h"
#include "haptics/proxy/triangle_trace.h"

namespace palpate {

// Identifies one triangle of a ContactWorld.
struct FaceRef {
  std::uint32_t body = 0;  // number of the body in ContactWorld::bodies
  std::uint32_t slot = 0;  // the triangle's slot in the body's index
  friend bool operator==(const FaceRef&, const FaceRef&) = default;
  friend auto operator<=>(const FaceRef&, const FaceRef&) = default;
};

// The contact of a proxy at some position with a triangle, and its contact plane. Solver frame,
// metres.
struct FaceContact {
  FaceRef face;
  Vec3 normal;         // unit, from the surface to the proxy
  double clearance_m;  // from the face to the proxy's surface, along the normal
  TriangleFeature feature = TriangleFeature::kFace;  // the face, edge or vertex that is touched
  Vec3 feature_point;                                // the point of the triangle that is touched
};

// The first obstacle of a step.
struct TraceHit {
  FaceContact contact;                                 // at the stopping point
  StepFraction fraction = StepFraction::start();       // part of the step up to the stopping point
  StepFraction meet_fraction = StepFraction::start();  // part up to the meeting, >= fraction
};

}  // namespace palpate
