// Surface point of a pixel from its blended channels (README 1), and the reverse.
//   z = Z/A   x = eye + z ray   n = N/|N|   f0 = F0/A   roughness = clamp(R/A, r_min, 1)   n.v = -n.d
//   a = smoothstep(0.5, 0.8, |N|/A), the consistency of the blended normals: at the rim of an object in front of a wall,
//   n belongs to neither surface, and its reflection would show an unrelated part of the scene.
// The weights k_s and tau are not divided by the coverage A: a half-covered pixel is half specular.
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

// The lobe is narrower than a pixel of any picture; below it the lobe's peak overflows float.
inline constexpr double kMinRoughness = 0.03;

template <class T>
struct PixelSums {  // what the rasteriser blends, or its gradient
  Vec3<T> normal{}, f0{};
  T roughness{}, zdepth{}, alpha{};
};

template <class T>
struct SurfacePoint {  // or its gradient
  Vec3<T> position{}, normal{}, f0{};
  T roughness{}, cosine{}, agreement{};  // cosine = n.v
};

// |N|/A with no reflection and with full reflection: two equal parts with normals 120 and 74 degrees apart.
inline constexpr double kNoAgreement = 0.5, kFullAgreement = 0.8;

template <class T>
T normal_agreement(const Vec3<T>& normal, const T& alpha) {
  const T x = (length(normal) / alpha - T(kNoAgreement)) / T(kFullAgreement - kNoAgreement);
  if (!(x > T(0))) return T(0);
  return x < T(1) ? x * x * (T(3) - T(2) * x) : T(1);
}

// The pixel's ray: eye + z * direction_per_z, and the unit vector from the surface to the eye.
template <class T>
struct PixelRay {
  Vec3<T> eye{}, direction_per_z{}, view{};
};

template <class T>
SurfacePoint<T> surface_point(const PixelSums<T>& s, const PixelRay<T>& ray) {
  SurfacePoint<T> p;
  const T inv = T(1) / s.alpha, r = s.roughness * inv;
  p.position = ray.eye + (s.zdepth * inv) * ray.direction_per_z;
  p.normal = normalized(s.normal);
  p.f0 = inv * s.f0;
  p.roughness = r < T(kMinRoughness) ? T(kMinRoughness) : r > T(1) ? T(1) : r;
  p.cosine = dot(p.normal, ray.view);
  p.agreement = normal_agreement(s.normal, s.alpha);
  return p;
}

template <class T>
PixelSums<T> surface_point_vjp(const PixelSums<T>& s, const PixelRay<T>& ray, const SurfacePoint<T>& g) {
  PixelSums<T> out;
  const T inv = T(1) / s.alpha, r = s.roughness * inv;
  out.normal = normalized_vjp(s.normal, g.normal + g.cosine * ray.view);
  out.f0 = inv * g.f0;
  out.roughness = r < T(kMinRoughness) || r > T(1) ? T(0) : inv * g.roughness;
  out.zdepth = inv * dot(g.position, ray.direction_per_z);
  out.alpha = -inv * (dot(s.f0, out.f0) + s.roughness * out.roughness + s.zdepth * out.zdepth);
  const T l = length(s.normal), span(kFullAgreement - kNoAgreement), x = (l * inv - T(kNoAgreement)) / span;
  if (x > T(0) && x < T(1)) {
    const T grad_ratio = T(6) * x * (T(1) - x) / span * g.agreement;
    out.normal += (grad_ratio * inv / l) * s.normal;
    out.alpha -= grad_ratio * l * inv * inv;
  }
  return out;
}

}  // namespace vitrine
