#pragma once

// The one place that knows which Embree is installed. Private to geometry: no public header
// includes this file. Written for 3.13 and 4.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace palpate::embree {

#if RTC_VERSION_MAJOR >= 4
using RayContext = RTCRayQueryContext;

inline void init(RayContext& context) {
  rtcInitRayQueryContext(&context);
}

inline void intersect(RTCScene scene, RTCRayHit& ray, RayContext& context) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
}
#else
using RayContext = RTCIntersectContext;

inline void init(RayContext& context) {
  rtcInitIntersectContext(&context);
}

inline void intersect(RTCScene scene, RTCRayHit& ray, RayContext& context) {
  rtcIntersect1(scene, &context, &ray);
}
#endif

// All bits, in either version: Embree 4 gives a geometry mask 1 by default, Embree 3 all bits.
inline constexpr unsigned kAllRays = 0xffffffffu;

}  // namespace palpate::embree
