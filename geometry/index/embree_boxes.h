#pragma once

// Boxes in an Embree BVH, used by SurfaceIndex and BoxTree. Private to geometry.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/exact/fraction.h"
#include "geometry/index/embree.h"
#include "geometry/index/pack_queries.h"

namespace palpate {

// Returns a float that is at least x. The function calls no library function, because queries use
// round_up().
inline float round_up(double x) {
  constexpr float kUlp = std::numeric_limits<float>::epsilon();
  const auto rounded = static_cast<float>(x);
  return rounded + (std::abs(rounded) * kUlp + std::numeric_limits<float>::min());
}
inline float round_down(double x) {
  return -round_up(-x);
}

// Margin for the rounding of a float box, in ulp of the largest float coordinate. The sum of 1 ulp
// for the box, 1 for a query point inside the box and 4 for a ray's origin, direction and end is
// doubled for safety.
inline constexpr int kFloatMarginUlps = 12;

// Bound on the rounding of a query point to float. kFloatMarginUlps covers only points inside the
// bounds of the boxes; this margin also covers points outside.
inline double float_point_margin_m(const Vec3& p) {
  return 4 * std::numeric_limits<float>::epsilon() * p.cwiseAbs().maxCoeff();
}

// A segment query in progress, as an Embree ray. The Embree context is the first member, so that a
// callback can cast the context pointer to the query.
struct SegmentQuery {
  embree::RayContext context;
  // The ray begins at the segment's fraction `enter`. Its direction is scaled to a largest
  // component of 1; length_m is the largest component of the caller's d.
  double enter;
  double length_m;
  float origin[3], displacement[3];  // the part of the segment inside the bounds
  RTCRayHit ray;

  // Starts a query along the segment p to p + d. The segment is first clipped to the bounds in
  // double, so that Embree's coordinates are no larger than the bounds. Returns false if d is zero
  // or no part of the segment is inside the bounds.
  bool begin(const Box& bounds, const Vec3& p, const Vec3& d);

  // For the callback: shortens the ray to this fraction of the segment. Embree compares boxes with
  // tfar in float, so the new end is rounded up. The callback never reports a hit, because Embree
  // would then skip boxes at equal distance.
  void end_at(QueryFraction fraction, const RTCIntersectFunctionNArguments* args) const {
    if (fraction >= QueryFraction::end()) return;
    float& tfar = RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0);
    tfar = std::min(tfar, round_up((fraction.value() - enter) * length_m));
  }

  // For the callback: ends the search, so that not even boxes that contain the origin are visited.
  static void end(const RTCIntersectFunctionNArguments* args) {
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0) =
        -std::numeric_limits<float>::infinity();
  }
};

// Tests which of sixteen boxes are within a radius of a point; returns one bit per box. The point
// is rounded to float, and the radius includes this rounding.
struct BoxesNear {
  float p[3];
  float radius;

  BoxesNear(const Vec3& point, double radius_m)
      : p{static_cast<float>(point.x()), static_cast<float>(point.y()),
          static_cast<float>(point.z())},
        radius(round_up(radius_m + float_point_margin_m(point))) {}
  std::uint32_t operator()(const BoxPack& boxes) const {
    BoxDistances distances;
    return boxes_within(boxes, p, radius, distances);
  }
};

// Tests which of sixteen boxes, grown by a radius, meet a segment query in progress; returns one
// bit per box.
struct BoxesAlong {
  SegmentQuery segment;
  float radius;

  std::uint32_t operator()(const BoxPack& boxes) const {
    return boxes_on_segment(boxes, segment.origin, segment.displacement, radius);
  }
};

class EmbreeBoxes {
 public:
  // boxes: grown by all margins. visit: called for each box that a ray meets; args->context is the
  // context of the SegmentQuery. The construction uses the calling thread only, so that it can
  // report a memory shortage in Embree by throwing std::bad_alloc.
  EmbreeBoxes(const std::vector<Box>& boxes, RTCIntersectFunctionN visit);
  ~EmbreeBoxes();
  EmbreeBoxes(const EmbreeBoxes&) = delete;
  EmbreeBoxes& operator=(const EmbreeBoxes&) = delete;

  // The memory needed for a tree over this number of boxes.
  static MemoryNeed memory_need(std::uint64_t boxes);
  std::size_t memory_bytes() const { return memory_bytes_; }

  // Calls `visit` for every box within the radius. The visitor returns the search radius for the
  // remaining boxes, including margins.
  template <typename Visit>
  void query_point(const float (&p)[3], float radius, Visit visit) const noexcept {
    RTCPointQuery query;
    query.x = p[0];
    query.y = p[1];
    query.z = p[2];
    query.time = 0.0f;
    query.radius = radius;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        scene_, &query, &context,
        [](RTCPointQueryFunctionArguments* args) {
          const float needed = (*static_cast<Visit*>(args->userPtr))(args->primID);
          if (needed >= args->query->radius) return false;
          args->query->radius = needed;
          return true;
        },
        &visit);
  }

  void query_segment(SegmentQuery& query) const noexcept {
    embree::intersect(scene_, query.ray, query.context);
  }

 private:
  RTCScene scene_;
  std::size_t memory_bytes_;
};

}  // namespace palpate
