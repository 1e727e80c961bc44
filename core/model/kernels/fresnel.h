// Schlick's Fresnel reflectance (README 2):  F = f0 + (1 - f0) (1 - c)^5,  c = n.v clamped to [0, 1].
#pragma once

#include "core/math/vec.h"

namespace vitrine {

template <class T>
struct Fresnel {
  Vec3<T> value{};
  T grazing{};  // (1 - c)^5
  T slope{};    // d grazing / d c
};

template <class T>
Fresnel<T> schlick(const Vec3<T>& f0, const T& cosine) {
  Fresnel<T> f;
  const bool inside = cosine > T(0) && cosine < T(1);
  const T x = inside ? T(1) - cosine : cosine > T(0) ? T(0) : T(1);
  const T x4 = x * x * x * x;
  f.grazing = x4 * x;
  f.slope = inside ? T(-5) * x4 : T(0);
  for (size_t c = 0; c < 3; ++c) f.value[c] = f0[c] + (T(1) - f0[c]) * f.grazing;
  return f;
}

// Adds to grad_f0 and grad_cosine.
template <class T>
void schlick_vjp(const Vec3<T>& f0, const Fresnel<T>& f, const Vec3<T>& grad_value, Vec3<T>& grad_f0, T& grad_cosine) {
  for (size_t c = 0; c < 3; ++c) {
    grad_f0[c] += (T(1) - f.grazing) * grad_value[c];
    grad_cosine += grad_value[c] * (T(1) - f0[c]) * f.slope;
  }
}

}  // namespace vitrine
