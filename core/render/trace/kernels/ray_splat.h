// Intersection of one surfel and one ray, its alpha, and the reverse (README 1, 2).
//
//   t = n.(mean - o)/(n.d)   x = o + t d - mean   u = r0.x/s_u   v = r1.x/s_v
//   alpha = min(0.99, opacity exp(-(u^2 + v^2)/2)), dropped below 1/255
#pragma once

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/vec.h"
#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

// Minimum |n.d| of a hit: below it x is ill-conditioned and its gradient explodes (the ray is parallel to the surfel).
inline constexpr double kGrazing = 1e-3;

template <class T>
struct RaySurfel {  // 16 scalars: one cache line in float
  Vec3<T> mean;
  T opacity;
  Vec3<T> normal;
  T cut;           // largest rho = u^2 + v^2 that counts: 2 ln(255 opacity)
  Vec3<T> axis_u;  // r0 / s_u
  T var_u;         // s_u^2
  Vec3<T> axis_v;
  T var_v;
};

template <class T>
struct TraceRay {
  Vec3<T> origin, direction;
  T near, far;
};

template <class T, class Mask = decltype(T() < T())>
struct RayHit {
  T t{}, u{}, v{};
  T alpha{};
  Mask free{};    // below the clamp: gradients flow
  Mask counts{};  // the hit is between near and far, and alpha is at least 1/255
};

template <class T>
VITRINE_HD RaySurfel<T> ray_surfel(const SurfelGeometry<T>& raw, const T& opacity) {
  using std::exp;
  using std::log;
  const Mat3<T> frame = rotation_matrix(normalized(raw.rotation));
  const T su = exp(raw.log_su), sv = exp(raw.log_sv);
  return {raw.mean, opacity, frame.c2, T(2) * log(opacity / T(kMinAlpha)), frame.c0 / su, su * su, frame.c1 / sv, sv * sv};
}

// u and v from hit.t, for forward and backward.
template <class T>
VITRINE_INLINE void place_hit(const RaySurfel<T>& s, const TraceRay<T>& ray, RayHit<T>& hit) {
  const Vec3<T> x = (ray.origin - s.mean) + hit.t * ray.direction;
  hit.u = dot(s.axis_u, x);
  hit.v = dot(s.axis_v, x);
}

// alpha is 0 if the hit does not count.
template <class T>
VITRINE_INLINE RayHit<T> ray_splat(const RaySurfel<T>& s, const TraceRay<T>& ray) {
  RayHit<T> hit;
  const T nd = dot(s.normal, ray.direction);
  hit.t = dot(s.normal, s.mean - ray.origin) / nd;
  place_hit(s, ray, hit);
  const T rho = hit.u * hit.u + hit.v * hit.v;
  const T peak = s.opacity * gaussian(rho);
  hit.counts =
      (nd * nd >= T(kGrazing * kGrazing)) & (hit.t > ray.near) & (hit.t <= ray.far) & (rho <= s.cut) & (peak >= T(kMinAlpha));
  hit.free = peak < T(kMaxAlpha);
  hit.alpha = select(hit.counts, select(hit.free, peak, T(kMaxAlpha)), T(0));
  return hit;
}

// Sums over the hits of one surfel; ray_surfel_vjp converts them to the gradients of its raw values.
template <class T>
struct HitMoments {
  T u{}, v{}, plane{};   // gradients of u and v, and of t over n.d
  T u_v{}, v_u{};        // gradient of u times v, of v times u
  T tilt_u{}, tilt_v{};  // r0 and r1 components of the normal's gradient, over s_u and s_v
  T log_su{}, log_sv{}, log_opacity{};

  VITRINE_HD HitMoments& operator+=(const HitMoments& m) {
    u += m.u;
    v += m.v;
    plane += m.plane;
    u_v += m.u_v;
    v_u += m.v_u;
    tilt_u += m.tilt_u;
    tilt_v += m.tilt_v;
    log_su += m.log_su;
    log_sv += m.log_sv;
    log_opacity += m.log_opacity;
    return *this;
  }
};

template <class T>
struct HitGrad {
  HitMoments<T> moments;
  Vec3<T> origin, direction;
};

// `grad_normal` is the gradient of the normal as stored (not flipped to face the ray).
template <class T>
VITRINE_INLINE HitGrad<T> ray_splat_vjp(const RaySurfel<T>& s, const TraceRay<T>& ray, const RayHit<T>& hit, const T& grad_alpha,
                                        const T& grad_t, const Vec3<T>& grad_normal) {
  HitGrad<T> g;
  HitMoments<T>& m = g.moments;
  const T log_alpha = hit.free ? grad_alpha * hit.alpha : T(0);
  m.u = -log_alpha * hit.u;
  m.v = -log_alpha * hit.v;
  m.log_opacity = log_alpha;
  m.log_su = log_alpha * (hit.u * hit.u);
  m.log_sv = log_alpha * (hit.v * hit.v);
  const Vec3<T> grad_x = m.u * s.axis_u + m.v * s.axis_v;
  const T along = dot(grad_x, ray.direction) + grad_t;
  m.plane = along / dot(s.normal, ray.direction);
  m.u_v = m.u * hit.v;
  m.v_u = m.v * hit.u;
  m.tilt_u = dot(grad_normal, s.axis_u) - m.plane * hit.u;
  m.tilt_v = dot(grad_normal, s.axis_v) - m.plane * hit.v;
  g.origin = grad_x - m.plane * s.normal;
  g.direction = hit.t * g.origin;
  return g;
}

template <class T>
struct RaySurfelGrad {
  SurfelGeometry<T> geometry;
  T raw_opacity;
};

// Gradients of the raw values. Only the rotational part of dL/d[r0 r1 n] is formed: a rotation has no other.
template <class T>
VITRINE_HD RaySurfelGrad<T> ray_surfel_vjp(const SurfelGeometry<T>& raw, const T& opacity, const HitMoments<T>& m) {
  using std::exp;
  const Mat3<T> frame = rotation_matrix(normalized(raw.rotation));
  const T su = exp(raw.log_su), sv = exp(raw.log_sv);
  RaySurfelGrad<T> g;
  g.geometry.mean = m.plane * frame.c2 - (m.u / su) * frame.c0 - (m.v / sv) * frame.c1;
  g.geometry.rotation = rotation_matrix_vjp(raw.rotation, Mat3<T>{(m.u_v * sv / su) * frame.c1, (m.v_u * su / sv) * frame.c0,
                                                                  (m.tilt_u * su) * frame.c0 + (m.tilt_v * sv) * frame.c1});
  g.geometry.log_su = m.log_su;
  g.geometry.log_sv = m.log_sv;
  g.raw_opacity = (T(1) - opacity) * m.log_opacity;
  return g;
}

}  // namespace vitrine
