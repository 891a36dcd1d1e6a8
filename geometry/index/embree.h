#pragma once

// The only file that depends on the version of Embree, 3.13 or 4. Private to geometry: no public
// header includes this file.

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

// A geometry mask with all bits set. The default mask is 1 in Embree 4 and all bits in Embree 3.
inline constexpr unsigned kAllRays = 0xffffffffu;

}  // namespace palpate::embree
