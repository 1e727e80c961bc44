// The one header that includes Embree: version 4 (Debian 13) or version 3 (Debian 12). Only sources include it; it declares what
// the two versions name differently. Both give a callback the context of its ray as `args->context`.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace vitrine::embree {

#if RTC_VERSION_MAJOR >= 4

// Base of the state of one ray; callbacks cast `args->context` to the derived type.
struct RayContext : RTCRayQueryContext {
  RayContext() { rtcInitRayQueryContext(this); }
};

// Nearest hit.
inline void intersect(RTCScene scene, RayContext& context, RTCRayHit& ray) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
}

// Any hit: `tfar` of the ray becomes negative.
inline void occluded(RTCScene scene, RayContext& context, RTCRay& ray) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded1(scene, &ray, &arguments);
}

#else

struct RayContext : RTCIntersectContext {
  RayContext() { rtcInitIntersectContext(this); }
};

inline void intersect(RTCScene scene, RayContext& context, RTCRayHit& ray) { rtcIntersect1(scene, &context, &ray); }

inline void occluded(RTCScene scene, RayContext& context, RTCRay& ray) { rtcOccluded1(scene, &context, &ray); }

#endif

}  // namespace vitrine::embree
