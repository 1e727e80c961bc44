// Torrance-Sparrow reflection (1967) with the GGX distribution (README 3; algorithms 3.4). alpha = roughness^2, h half vector,
// l = reflected(v, h).
//   D(x)  = alpha^2 / (pi q^2),  q = x^2 (alpha^2 - 1) + 1,  x = n.h
//   G1(x) = x / (x (1 - k) + k),  k = alpha / 2 (Karis 2013),  G = G1(n.v) G1(n.l)
//   integral of D G F/(4 n.v n.l) L(l) n.l dl  =  E[ W F L(l) ]  with h drawn with density D n.h (Walter et al. 2007, eq. 41):
//   W = G (v.h) / ((n.v) (n.h)) = (v.h)/(n.h) * G1(n.l) / (n.v (1 - k) + k)
//
// A sampled ray is differentiated with the sample fixed in the frame of the normal: h rotates with n (mirror.h), so the
// gradient of the normal follows the ray as for a mirror, and the density is a constant D0. The roughness then acts through
// D(n.h; alpha)/D0, whose value is 1 (detached sampling), and through G.
#pragma once

#include <cmath>
#include <numbers>

#include "core/render/model/kernels/mirror.h"

namespace vitrine {

// Lower clamp of cosines: no division by zero at grazing angles.
inline constexpr double kMinCosine = 1e-4;

template <class T>
struct GgxLobe {
  T value{}, slope_alpha{};  // D and its derivative
};
template <class T>
GgxLobe<T> ggx_distribution(const T& alpha, const T& x) {
  const T a2 = alpha * alpha, q = x * x * (a2 - T(1)) + T(1), pi(std::numbers::pi);
  return {a2 / (pi * q * q), T(2) * alpha * (q - T(2) * a2 * x * x) / (pi * q * q * q)};
}

template <class T>
T smith_g1(const T& x, const T& k) {
  return x / (x * (T(1) - k) + k);
}

// Samples a half vector with density D(n.h) n.h from two uniform numbers in [0, 1).
template <class T>
Vec3<T> ggx_half_vector(const Vec3<T>& n, const T& alpha, const T& u0, const T& u1) {
  using std::cos, std::sin, std::sqrt;
  const T cosine = sqrt((T(1) - u1) / (T(1) + (alpha * alpha - T(1)) * u1)), phi = T(2 * std::numbers::pi) * u0;
  const T inside = T(1) - cosine * cosine, sine = inside > T(0) ? sqrt(inside) : T(0);
  Vec3<T> t0, t1;
  tangents(n, t0, t1);
  return sine * (cos(phi) * t0 + sin(phi) * t1) + cosine * n;
}

template <class T>
struct GlossyRay {
  Vec3<T> half, direction;
  T n_dot_h{}, n_dot_v{}, n_dot_l{}, v_dot_h{}, alpha{};
  T weight{};  // W; zero: below the horizon, not traced
};

// The ray of a half vector `half` sampled around `normal` with `roughness`. `density` is D0; 0 uses the current D.
template <class T>
GlossyRay<T> glossy_ray(const Vec3<T>& view, const Vec3<T>& normal, const Vec3<T>& half, const T& roughness,
                        const T& density = T(0)) {
  GlossyRay<T> r;
  r.half = half;
  r.direction = reflected(view, half);
  r.alpha = roughness * roughness;
  r.n_dot_h = dot(normal, half);
  r.n_dot_l = dot(normal, r.direction);
  r.v_dot_h = dot(view, half);
  const T cosine = dot(normal, view);
  r.n_dot_v = cosine > T(kMinCosine) ? cosine : T(kMinCosine);
  if (!(r.n_dot_l > T(kMinCosine) && r.v_dot_h > T(kMinCosine) && r.n_dot_h > T(kMinCosine))) return r;
  const T k = T(0.5) * r.alpha;
  r.weight = r.v_dot_h / r.n_dot_h * smith_g1(r.n_dot_l, k) / (r.n_dot_v * (T(1) - k) + k);
  if (density > T(0)) r.weight = r.weight * (ggx_distribution(r.alpha, r.n_dot_h).value / density);
  return r;
}

template <class T>
struct GlossyGrad {
  Vec3<T> normal{};
  T roughness{};
};

// Reverse of glossy_ray at density = D: from the gradients of the ray's direction and weight.
template <class T>
GlossyGrad<T> glossy_ray_vjp(const Vec3<T>& view, const Vec3<T>& normal, const T& roughness, const GlossyRay<T>& r,
                             const Vec3<T>& grad_direction, const T& grad_weight) {
  GlossyGrad<T> g;
  if (!(r.weight > T(0))) return g;
  const T gw = grad_weight * r.weight, k = T(0.5) * r.alpha;
  const T below_v = r.n_dot_v * (T(1) - k) + k, below_l = r.n_dot_l * (T(1) - k) + k;
  // d ln W: of the cosines with the sample fixed in the frame of the normal (n.h constant), and of alpha.
  const T l_slope = k / (r.n_dot_l * below_l);
  const T v_slope = dot(normal, view) > T(kMinCosine) ? -(T(1) - k) / below_v : T(0);
  const GgxLobe<T> lobe = ggx_distribution(r.alpha, r.n_dot_h);
  const T alpha_slope = lobe.slope_alpha / lobe.value - T(0.5) * ((T(1) - r.n_dot_v) / below_v + (T(1) - r.n_dot_l) / below_l);
  g.roughness = gw * alpha_slope * T(2) * roughness;
  const Vec3<T> grad_l = grad_direction + (gw * l_slope) * normal;
  const Vec3<T> grad_h = reflected_vjp(view, r.half, grad_l) + (gw / r.v_dot_h) * view;
  g.normal = carried_vjp(r.half, normal, grad_h) + (gw * l_slope) * r.direction + (gw * v_slope) * view;
  return g;
}

}  // namespace vitrine
