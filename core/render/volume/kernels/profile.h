// A 3D Gaussian along one ray is a 1D Gaussian: density(t) = depth N(t; at, width), so that its optical depth before t is
// depth Phi((t - at) / width). With the reverse, templated on the scalar.
#pragma once

#include <cmath>

#include "core/render/volume/kernels/density.h"
#include "core/render/volume/kernels/exponential.h"

namespace vitrine {

template <class T>
struct RayProfile {
  T depth{};  // line integral of the density: optical depth
  T at{};     // distance along the ray of its largest density, scene units
  T width{};  // standard deviation along the ray, scene units
};

// Light that a ray brings through a volume: what the volume emits towards its origin, and the part of what is behind it.
template <class T>
struct VolumeLight {
  Vec3<T> color{};
  T transmittance{};
  bool operator==(const VolumeLight&) const = default;
};
using VolumeLightf = VolumeLight<float>;
using VolumeLightd = VolumeLight<double>;

template <class T>
RayProfile<T> ray_profile(const Whitened<T>& w, const WhitenedLine<T>& line) {
  using std::sqrt;
  return {line_integral(w, line), line.along, T(1) / sqrt(line.squared)};
}

// Adds the gradients for a gradient `g` of the profile. With q = |u'|^2 and the closest point p = o' + t u':
// d depth as line_integral_vjp; dt: do' = -u' / q, du' = -(p + t u') / q; d width: du' = -width^3 u'.
template <class T>
void ray_profile_vjp(const Whitened<T>& w, const Vec3<T>& mean, const Vec3<T>& origin, const Vec3<T>& direction,
                     const RayProfile<T>& g, WhitenedGradient<T>& grad) {
  const WhitenedLine<T> line = whitened_line(w, mean, origin, direction);
  const RayProfile<T> profile = ray_profile(w, line);
  const T depth = g.depth * profile.depth, at = g.at / line.squared;
  const T width = g.width * profile.width / line.squared;
  const Vec3<T> of_depth = -depth * line.closest, r = origin - mean;
  const Vec3<T> of_origin = of_depth - at * line.direction;
  const Vec3<T> of_direction = line.along * of_origin - at * line.closest - (depth / line.squared + width) * line.direction;
  grad.offset += of_origin;
  for (size_t j = 0; j < 3; ++j) grad.matrix.column(j) += r[j] * of_origin + direction[j] * of_direction;
  grad.log_density = grad.log_density + depth;
}

// Phi in floats without branches or tables, so that loops over arrays of rays become SIMD code.
struct NormalCdf {
  float below, density;  // Phi(x) and its derivative
};

// By the rational approximation 7.1.26 of Abramowitz and Stegun, Handbook of Mathematical Functions: error of Phi below 2e-7.
// Densities below 2e-22 stay at that: no denormal numbers.
inline __attribute__((always_inline)) NormalCdf normal_cdf(float x) {
  const float e = exponential<-50>(-0.5f * x * x);
  const float t = 1.f / (1.f + (0.3275911f * 0.707106781f) * std::fabs(x));
  float p = 1.061405429f;
  p = p * t - 1.453152027f;
  p = p * t + 1.421413741f;
  p = p * t - 0.284496736f;
  p = p * t + 0.254829592f;
  return {0.5f + std::copysign(0.5f - 0.5f * p * t * e, x), 0.398942280f * e};
}

// The exact values, for the reference.
inline double normal_cdf(double x) { return 0.5 * std::erfc(-x * 0.70710678118654752); }

}  // namespace vitrine
