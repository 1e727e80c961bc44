// Features that a surfel contributes to its pixels: colour from spherical harmonics, facing normal, materials (README 4).
// colour = max(0, 0.5 + sum_k Y_k(dir) h_k) in linear radiance, dir from the eye to the mean.
#pragma once

#include "core/foundation/math/spherical_harmonics.h"
#include "core/foundation/math/vec.h"
#include "core/render/raster/aovs.h"
#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

inline constexpr size_t kMaxShCoefficients = sh_coefficient_count(3);
// Offsets of the blended features, in the order of the AOV table.
inline constexpr size_t kColourAt = 0, kNormalAt = 3, kMaterialAt = 6, kMaterialWidth = 6;
inline constexpr size_t kMaxFeatures = kMaterialAt + kMaterialWidth;
static_assert(
    [] {
      size_t width = 0;
      for (const AovRow& r : kAovs) width += r.feature ? static_cast<size_t>(r.width) : 0;
      return width;
    }() == kMaxFeatures,
    "features of the table and of the kernels agree");

template <class T>
struct ShColour {
  Vec3<T> value;
  Vec3<T> offset;  // mean - eye
  Vec3<T> sum;     // before the clamp
  T basis[kMaxShCoefficients];
};

// `h`: coefficient k of channel c is h[3 * k + c].
template <class T>
VITRINE_HD ShColour<T> sh_colour(int degree, const Vec3<T>& mean, const Vec3<T>& eye, const T* h) {
  ShColour<T> s;
  s.offset = mean - eye;
  sh_basis(degree, normalized(s.offset), s.basis);
  s.sum = {T(0.5), T(0.5), T(0.5)};
  for (size_t k = 0; k < sh_coefficient_count(degree); ++k)
    for (size_t c = 0; c < 3; ++c) s.sum[c] = s.sum[c] + s.basis[k] * h[3 * k + c];
  for (size_t c = 0; c < 3; ++c) s.value[c] = select(s.sum[c] > T(0), s.sum[c], T(0));
  return s;
}

// Writes grad_h[3 * k + c] (overwrites) and returns the gradient of the mean through the direction.
template <class T>
VITRINE_HD Vec3<T> sh_colour_vjp(int degree, const ShColour<T>& s, const T* h, const Vec3<T>& grad_value, T* grad_h) {
  Vec3<T> g;
  for (size_t c = 0; c < 3; ++c) g[c] = select(s.sum[c] > T(0), grad_value[c], T(0));
  T weight[kMaxShCoefficients];
  for (size_t k = 0; k < sh_coefficient_count(degree); ++k) {
    weight[k] = g.x * h[3 * k] + g.y * h[3 * k + 1] + g.z * h[3 * k + 2];
    for (size_t c = 0; c < 3; ++c) grad_h[3 * k + c] = s.basis[k] * g[c];
  }
  return normalized_vjp(s.offset, sh_basis_vjp(degree, normalized(s.offset), weight));
}

}  // namespace vitrine
