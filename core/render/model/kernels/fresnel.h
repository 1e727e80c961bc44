// Fresnel reflectance (README 2):  F = f0 + (1 - f0) q(c),  c = n.v clamped to [0, 1], f0 the reflectance at normal incidence.
// q increases from 0 to 1 at grazing incidence:
//   surfaces       q = (1 - c)^5                                       (Schlick 1994)
//   thin glass     q = (S(c) - S(1)) / (1 - S(1)),  S = 2R/(1+R)        R: unpolarised Fresnel reflectance at index 1.5
//   solid glass    q = (R(c) - R(1)) / (1 - R(1))                       one wall; rays hit the others on their path
// A pane reflects at both sides, repeatedly: S is the sum of all reflections. It is steeper than Schlick's curve: 0.17 and 0.43
// at 61 and 77 degrees where Schlick's, from the same 0.077 at normal incidence, gives 0.11 and 0.34. Coatings change f0 but
// not q.
// degrees where that, from the same 0.077 head on, has 0.11 and 0.34. Coatings change f0 and keep the shape.
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

inline constexpr double kGlassIndex = 1.5;
// Reflectance of a pane at normal incidence: S(1) with R = ((n - 1)/(n + 1))^2.
inline constexpr double kPaneReflectance = [] {
  constexpr double r = (kGlassIndex - 1) / (kGlassIndex + 1), R = r * r;
  return 2 * R / (1 + R);
}();
// Reflectance of one wall, R(1).
inline constexpr double kWallReflectance = (kGlassIndex - 1) * (kGlassIndex - 1) / ((kGlassIndex + 1) * (kGlassIndex + 1));

template <class T>
struct Grazing {
  T value{}, slope{};  // q, dq/dc
};

template <class T>
struct Fresnel {
  Vec3<T> value{};
  T grazing{};  // q
  T slope{};    // dq/dc
  T clear{};    // dq/d(clear)
};

template <class T>
Grazing<T> schlick_grazing(const T& cosine) {
  const bool inside = cosine > T(0) && cosine < T(1);
  const T x = inside ? T(1) - cosine : cosine > T(0) ? T(0) : T(1);
  const T x4 = x * x * x * x;
  return {x4 * x, inside ? T(-5) * x4 : T(0)};
}

// R and dR/dc of one wall, for c in (0, 1).
template <class T>
Grazing<T> wall_reflectance(const T& cosine) {
  using std::sqrt;
  // Amplitudes (c - w)/(c + w) and (n^2 c - w)/(n^2 c + w) with w = n cos(refracted).
  const T n2(kGlassIndex * kGlassIndex), w = sqrt(n2 - T(1) + cosine * cosine);
  const T rise = T(2) * (w - cosine * cosine / w);
  const T a = T(1) / (cosine + w), b = T(1) / (n2 * cosine + w);
  const T s = (cosine - w) * a, p = (n2 * cosine - w) * b;
  return {T(0.5) * (s * s + p * p), s * rise * a * a + p * n2 * rise * b * b};
}

template <class T>
Grazing<T> sheet_grazing(const T& cosine) {
  if (!(cosine > T(0))) return {T(1), T(0)};
  if (!(cosine < T(1))) return {T(0), T(0)};
  const auto [R, slope_R] = wall_reflectance(cosine);
  const T per(1 / (1 - kPaneReflectance)), both = T(1) / (T(1) + R);
  return {(T(2) * R * both - T(kPaneReflectance)) * per, T(2) * slope_R * both * both * per};
}

template <class T>
Grazing<T> wall_grazing(const T& cosine) {
  if (!(cosine > T(0))) return {T(1), T(0)};
  if (!(cosine < T(1))) return {T(0), T(0)};
  const auto [R, slope_R] = wall_reflectance(cosine);
  const T per(1 / (1 - kWallReflectance));
  return {(R - T(kWallReflectance)) * per, slope_R * per};
}

// `clear`: degree to which the surface is thin glass, or one wall of solid glass, in [0, 1].
template <class T>
Fresnel<T> fresnel(const Vec3<T>& f0, const T& cosine, const T& clear, bool solid = false) {
  const Grazing<T> surface = schlick_grazing(cosine);
  const Grazing<T> sheet = !(clear > T(0)) ? surface : solid ? wall_grazing(cosine) : sheet_grazing(cosine);
  Fresnel<T> f;
  f.clear = sheet.value - surface.value;
  f.grazing = surface.value + clear * f.clear;
  f.slope = surface.slope + clear * (sheet.slope - surface.slope);
  for (size_t c = 0; c < 3; ++c) f.value[c] = f0[c] + (T(1) - f0[c]) * f.grazing;
  return f;
}

template <class T>
Fresnel<T> schlick(const Vec3<T>& f0, const T& cosine) {
  return fresnel(f0, cosine, T(0));
}

// Adds to grad_f0, grad_cosine and grad_clear.
template <class T>
void fresnel_vjp(const Vec3<T>& f0, const Fresnel<T>& f, const Vec3<T>& grad_value, Vec3<T>& grad_f0, T& grad_cosine,
                 T& grad_clear) {
  T grad_q(0);
  for (size_t c = 0; c < 3; ++c) {
    grad_f0[c] += (T(1) - f.grazing) * grad_value[c];
    grad_q += grad_value[c] * (T(1) - f0[c]);
  }
  grad_cosine += grad_q * f.slope;
  grad_clear += grad_q * f.clear;
}

}  // namespace vitrine
