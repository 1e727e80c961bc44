// One surfel and one ray: where they meet, how much the surfel hides there, and the reverse (README 1, 2, 5).
//
//   t = n.(mean - o)/(n.d)   x = o + t d - mean   u = r0.x/s_u   v = r1.x/s_v
//   f = min(spread t, max_footprint)   q_u = s_u^2/(s_u^2 + f^2)   q_v alike       (f = 0: both 1)
//   alpha = min(0.99, opacity sqrt(q_u q_v) exp(-(q_u u^2 + q_v v^2)/2)), dropped below 1/255
//
// The footprint f convolves the surfel with the cross-section of the ray's cone and keeps the amount of light that it blocks.
#pragma once

#include "core/math/rigid.h"
#include "core/math/vec.h"
#include "core/render/kernels/constants.h"
#include "core/render/kernels/project.h"

namespace vitrine {

// |n.d| below this: the ray runs along the surfel, x is ill-conditioned and its gradient explodes; there is no hit.
inline constexpr double kGrazing = 1e-3;

template <class T>
struct RaySurfel {  // 16 scalars: one cache line in float
  Vec3<T> mean;
  T opacity;
  Vec3<T> normal;
  T cut;           // largest rho that counts when there is no footprint: 2 ln(255 opacity)
  Vec3<T> axis_u;  // r0 / s_u
  T var_u;         // s_u^2
  Vec3<T> axis_v;
  T var_v;
};

template <class T>
struct TraceRay {
  Vec3<T> origin, direction;
  T near, far;
  T spread, max_footprint;
};

template <class T, class Mask = decltype(T() < T())>
struct RayHit {
  T t{}, u{}, v{};
  T footprint{}, q_u{}, q_v{};
  T alpha{};
  Mask free{};    // below the clamp: gradients flow
  Mask counts{};  // they meet between near and far, and the surfel hides at least 1/255
};

template <class T>
RaySurfel<T> ray_surfel(const SurfelGeometry<T>& raw, const T& opacity) {
  using std::exp;
  using std::log;
  const Mat3<T> frame = rotation_matrix(normalized(raw.rotation));
  const T su = exp(raw.log_su), sv = exp(raw.log_sv);
  return {raw.mean, opacity, frame.c2, T(2) * log(opacity / T(kMinAlpha)), frame.c0 / su, su * su, frame.c1 / sv, sv * sv};
}

// Fills in what follows from hit.t, but alpha. Forward and backward both come through here.
template <bool kFootprint, class T>
VITRINE_INLINE void place_hit(const RaySurfel<T>& s, const TraceRay<T>& ray, RayHit<T>& hit) {
  const Vec3<T> x = (ray.origin - s.mean) + hit.t * ray.direction;
  hit.u = dot(s.axis_u, x);
  hit.v = dot(s.axis_v, x);
  hit.footprint = T(0);
  hit.q_u = hit.q_v = T(1);
  if constexpr (kFootprint) {
    const T wide = ray.spread * hit.t;
    hit.footprint = select(wide < ray.max_footprint, wide, ray.max_footprint);
    const T ff = hit.footprint * hit.footprint;
    hit.q_u = s.var_u / (s.var_u + ff);
    hit.q_v = s.var_v / (s.var_v + ff);
  }
}

// Without kFootprint the ray's spread counts as zero. alpha is 0 where the hit does not count.
template <bool kFootprint, class T>
VITRINE_INLINE RayHit<T> ray_splat(const RaySurfel<T>& s, const TraceRay<T>& ray) {
  using std::sqrt;
  RayHit<T> hit;
  const T nd = dot(s.normal, ray.direction);
  hit.t = dot(s.normal, s.mean - ray.origin) / nd;
  place_hit<kFootprint>(s, ray, hit);
  const T rho = hit.q_u * (hit.u * hit.u) + hit.q_v * (hit.v * hit.v);
  T peak = s.opacity * gaussian(rho);
  if constexpr (kFootprint) peak = peak * sqrt(hit.q_u * hit.q_v);
  hit.counts =
      (nd * nd >= T(kGrazing * kGrazing)) & (hit.t > ray.near) & (hit.t <= ray.far) & (rho <= s.cut) & (peak >= T(kMinAlpha));
  hit.free = peak < T(kMaxAlpha);
  hit.alpha = select(hit.counts, select(hit.free, peak, T(kMaxAlpha)), T(0));
  return hit;
}
// The same for one surfel and one ray, whether it has a spread or not.
template <class T>
RayHit<T> ray_splat(const RaySurfel<T>& s, const TraceRay<T>& ray) {
  return ray.spread > T(0) ? ray_splat<true>(s, ray) : ray_splat<false>(s, ray);
}

// Sums over the hits of one surfel, from which ray_surfel_vjp makes the gradients of its raw values.
template <class T>
struct HitMoments {
  T u{}, v{}, plane{};   // gradients of u and v, and of t over n.d
  T u_v{}, v_u{};        // gradient of u times v, of v times u
  T tilt_u{}, tilt_v{};  // r0 and r1 components of the normal's gradient, over s_u and s_v
  T log_su{}, log_sv{}, log_opacity{};

  HitMoments& operator+=(const HitMoments& m) {
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
  T spread;
};

// `grad_normal` is that of the normal as stored (not flipped to face the ray).
template <class T>
VITRINE_INLINE HitGrad<T> ray_splat_vjp(const RaySurfel<T>& s, const TraceRay<T>& ray, const RayHit<T>& hit, const T& grad_alpha,
                                        const T& grad_t, const Vec3<T>& grad_normal) {
  HitGrad<T> g;
  HitMoments<T>& m = g.moments;
  const T log_alpha = hit.free ? grad_alpha * hit.alpha : T(0);
  const T qu_u = hit.q_u * hit.u, qv_v = hit.q_v * hit.v;
  m.u = -log_alpha * qu_u;
  m.v = -log_alpha * qv_v;
  m.log_opacity = log_alpha;
  m.log_su = log_alpha * ((T(1) - hit.q_u) + qu_u * qu_u);
  m.log_sv = log_alpha * ((T(1) - hit.q_v) + qv_v * qv_v);
  const Vec3<T> grad_x = m.u * s.axis_u + m.v * s.axis_v;
  T along = dot(grad_x, ray.direction) + grad_t;
  g.spread = T(0);
  if (hit.footprint > T(0) && hit.footprint < ray.max_footprint) {
    const T grad_footprint =
        -log_alpha * hit.footprint * (hit.q_u / s.var_u * (T(1) - qu_u * hit.u) + hit.q_v / s.var_v * (T(1) - qv_v * hit.v));
    along += grad_footprint * ray.spread;
    g.spread = grad_footprint * hit.t;
  }
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

// Gradients of the raw values. Only the part of dL/d[r0 r1 n] that turns the frame is formed: a rotation has no other.
template <class T>
RaySurfelGrad<T> ray_surfel_vjp(const SurfelGeometry<T>& raw, const T& opacity, const HitMoments<T>& m) {
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
