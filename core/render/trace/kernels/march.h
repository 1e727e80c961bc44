// Front-to-back blending of the sorted hits of one ray, and its reverse (README 3, 4). The caller guarantees the order.
//
//   w_i = alpha_i T_i while T_i >= min_transmittance     V_i = c_i.g_color + t_i g_distance + n_i.g_normal
//   dL/d alpha_i = T_i V_i - (sum_{j>i} w_j V_j + T_end g_transmittance)/(1 - alpha_i)
#pragma once

#include "core/foundation/math/spherical_harmonics.h"
#include "core/foundation/math/vec.h"
#include "core/render/raster/kernels/shade.h"

namespace vitrine {

template <class T>
struct MarchValues {  // of one ray, or their gradients
  Vec3<T> color{};
  T transmittance{};
  T distance{};
  T first_hit{};
  Vec3<T> normal{};
};

// Transmittance starts at one, all other values at zero.
template <class T>
struct March {
  MarchValues<T> sum{.transmittance = T(1)};
  T weight{};

  // `normal` faces the ray.
  VITRINE_INLINE void blend(const T& t, const T& alpha, const Vec3<T>& color, const Vec3<T>& normal, const T& first_hit_weight) {
    const T w = alpha * sum.transmittance;
    sum.color = sum.color + w * color;
    sum.distance = sum.distance + w * t;
    sum.normal = sum.normal + w * normal;
    const bool reached = weight >= first_hit_weight;
    weight = weight + w;
    if (!reached && weight >= first_hit_weight) sum.first_hit = t;
    sum.transmittance = sum.transmittance * (T(1) - alpha);
  }
};

template <class T>
struct BlendGrad {
  T alpha, t;
  Vec3<T> color, normal;
};

// Called back to front. `behind` is sum_{j>i} w_j V_j + T_end g_transmittance, updated on return; `transmittance` is the one in
// front of the hit.
template <class T>
VITRINE_INLINE BlendGrad<T> blend_hit_vjp(const T& transmittance, const T& t, const T& alpha, const Vec3<T>& color,
                                          const Vec3<T>& normal, bool is_first_hit, const MarchValues<T>& grad, T& behind) {
  const T w = alpha * transmittance;
  const T value = dot(color, grad.color) + t * grad.distance + dot(normal, grad.normal);
  BlendGrad<T> g;
  g.alpha = transmittance * value - behind / (T(1) - alpha);
  g.t = w * grad.distance;
  if (is_first_hit) g.t = g.t + grad.first_hit;
  g.color = w * grad.color;
  g.normal = w * grad.normal;
  behind = behind + w * value;
  return g;
}

// Colour towards the ray: max(0, 0.5 + sum_k Y_k(direction) h_k). The basis belongs to the ray, not to the hit. `h`:
// coefficient k of channel c is h[3 * k + c], a pointer or what else has such an operator.
template <class T, class Coefficients>
VITRINE_HD Vec3<T> ray_color(int degree, const T* basis, const Coefficients& h) {
  Vec3<T> sum{T(0.5), T(0.5), T(0.5)};
  for (size_t k = 0; k < sh_coefficient_count(degree); ++k)
    for (size_t c = 0; c < 3; ++c) sum[c] = sum[c] + basis[k] * h[3 * k + c];
  for (size_t c = 0; c < 3; ++c) sum[c] = sum[c] > T(0) ? sum[c] : T(0);
  return sum;
}

// Reverse for the direction, where `color` is positive: basis_weight[k] += grad.h_k, which sh_basis_vjp converts to the gradient
// of the direction once per ray.
template <class T, class Coefficients>
VITRINE_HD void add_basis_weights(int degree, const Coefficients& h, const Vec3<T>& color, const Vec3<T>& grad_color,
                                  T* basis_weight) {
  for (size_t c = 0; c < 3; ++c) {
    if (!(color[c] > T(0))) continue;
    for (size_t k = 0; k < sh_coefficient_count(degree); ++k) basis_weight[k] += T(h[3 * k + c]) * grad_color[c];
  }
}

// The whole reverse: grad_h[3 * k + c] += Y_k grad_c where `color` is positive, and add_basis_weights().
template <class T>
void ray_color_vjp(int degree, const T* basis, const T* h, const Vec3<T>& color, const Vec3<T>& grad_color, T* grad_h,
                   T* basis_weight) {
  for (size_t c = 0; c < 3; ++c) {
    if (!(color[c] > T(0))) continue;
    for (size_t k = 0; k < sh_coefficient_count(degree); ++k) grad_h[3 * k + c] += basis[k] * grad_color[c];
  }
  add_basis_weights(degree, h, color, grad_color, basis_weight);
}

}  // namespace vitrine
