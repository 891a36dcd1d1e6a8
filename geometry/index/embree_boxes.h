#pragma once

// Boxes in a BVH of Embree's: what SurfaceIndex and BoxTree search with. Private to geometry.

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

// At least to the next float; without a call, since queries do it.
inline float round_up(double x) {
  constexpr float kUlp = std::numeric_limits<float>::epsilon();
  const auto rounded = static_cast<float>(x);
  return rounded + (std::abs(rounded) * kUlp + std::numeric_limits<float>::min());
}
inline float round_down(double x) {
  return -round_up(-x);
}

// How far a float box may be off: rounding of the box (1 ulp), of a query point inside it (1), of a
// ray's origin, direction and end (4), with as much again in hand. In ulp of the largest float
// coordinate.
inline constexpr int kFloatMarginUlps = 12;

// What rounding a query point to float can cost, when it lies outside the box that the margins of
// the boxes are for.
inline double float_point_margin_m(const Vec3& p) {
  return 4 * std::numeric_limits<float>::epsilon() * p.cwiseAbs().maxCoeff();
}

// A segment on its way through boxes, as a ray. The Embree context is the first member, so that a
// callback can find the rest from the pointer it is given.
struct SegmentQuery {
  embree::RayContext context;
  // The ray begins at the segment's fraction `enter`, and its direction has length 1 (largest
  // component), which the caller's segment has not.
  double enter;
  double length_m;
  float origin[3], displacement[3];  // the part of the segment that is inside the bounds
  RTCRayHit ray;

  // The segment p to p + d. It is clipped to the bounds in double first: Embree then works on
  // coordinates no larger than those. False if none of it, or no length, is inside.
  bool begin(const Box& bounds, const Vec3& p, const Vec3& d);

  // For the callback: the ray need go no farther than this fraction of the segment. Embree compares
  // boxes with tfar in float, so the new end is rounded up; nothing is ever reported as a hit,
  // because a report would let Embree skip boxes at equal distance.
  void end_at(QueryFraction fraction, const RTCIntersectFunctionNArguments* args) const {
    if (fraction >= QueryFraction::end()) return;
    float& tfar = RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0);
    tfar = std::min(tfar, round_up((fraction.value() - enter) * length_m));
  }

  // For the callback: nothing more is wanted, not even boxes that hold the origin.
  static void end(const RTCIntersectFunctionNArguments* args) {
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0) =
        -std::numeric_limits<float>::infinity();
  }
};

// Which of sixteen boxes come within a radius of a point: a bit each. The point is rounded, and the
// radius allows for that.
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

// Which of sixteen boxes, grown by a radius, a segment meets that has begun: a bit each.
struct BoxesAlong {
  SegmentQuery segment;
  float radius;

  std::uint32_t operator()(const BoxPack& boxes) const {
    return boxes_on_segment(boxes, segment.origin, segment.displacement, radius);
  }
};

class EmbreeBoxes {
 public:
  // boxes: grown by every margin. visit: called for each box that a ray meets; args->context is
  // that of the SegmentQuery. Works on the calling thread alone, so that what Embree runs out of is
  // thrown here: std::bad_alloc.
  EmbreeBoxes(const std::vector<Box>& boxes, RTCIntersectFunctionN visit);
  ~EmbreeBoxes();
  EmbreeBoxes(const EmbreeBoxes&) = delete;
  EmbreeBoxes& operator=(const EmbreeBoxes&) = delete;

  // What a tree over so many boxes takes.
  static MemoryNeed memory_need(std::uint64_t boxes);
  std::size_t memory_bytes() const { return memory_bytes_; }

  // Calls `visit` for every box within the radius. The visitor returns the radius it still needs,
  // margins included.
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
