// Values of one 3D Gaussian along a line and at a point, each with its reverse, templated on the scalar.
//
// Line x(t) = o + t u. In the whitened frame o' = W (o - m), u' = W u: the exponent is |o' + t u'|^2 / 2, a parabola in t with
// its minimum at the whitened closest point p = o' - (o'.u' / u'.u') u', so that the integral over all t is
//   I = rho sqrt(2 pi) s exp(-|p|^2 / 2),   s = 1 / |u'| = 1 / sqrt(u^T S^-1 u),
// exact for any camera (3DGEER, arXiv:2505.24053; R2-Gaussian, arXiv:2405.20693: the factor s sqrt(2 pi), missing in splatting
// of screen-space Gaussians, makes densities of different views agree). t has the unit of length for a unit vector u.
#pragma once

#include "core/render/volume/gaussian3.h"

namespace vitrine {

inline constexpr double kSqrtTwoPi = 2.5066282746310002;

template <class T>
struct WhitenedLine {
  Vec3<T> direction, closest;  // u', p
  T along;                     // t of p
  T squared;                   // |u'|^2
};

template <class T>
WhitenedLine<T> whitened_line(const Whitened<T>& w, const Vec3<T>& mean, const Vec3<T>& origin, const Vec3<T>& direction) {
  WhitenedLine<T> line;
  line.direction = w.matrix * direction;
  const Vec3<T> o = w.matrix * (origin - mean);
  line.squared = squared_length(line.direction);
  line.along = -dot(o, line.direction) / line.squared;
  line.closest = o + line.along * line.direction;
  return line;
}

template <class T>
T line_integral(const Whitened<T>& w, const WhitenedLine<T>& line) {
  using std::exp;
  using std::sqrt;
  return w.density * T(kSqrtTwoPi) / sqrt(line.squared) * exp(T(-0.5) * squared_length(line.closest));
}

// Adds the gradients for a gradient `g` of the integral: do' = -g I p (p is perpendicular to u', so t does not count) and
// du' = g I (-t p - u' / |u'|^2); dW = do' (o - m)^T + du' u^T.
template <class T>
void line_integral_vjp(const Whitened<T>& w, const Vec3<T>& mean, const Vec3<T>& origin, const Vec3<T>& direction, const T& g,
                       WhitenedGradient<T>& grad) {
  const WhitenedLine<T> line = whitened_line(w, mean, origin, direction);
  const T value = g * line_integral(w, line);
  const Vec3<T> of_origin = -value * line.closest, r = origin - mean;
  const Vec3<T> of_direction = line.along * of_origin - value / line.squared * line.direction;
  grad.offset += of_origin;
  for (size_t j = 0; j < 3; ++j) grad.matrix.column(j) += r[j] * of_origin + direction[j] * of_direction;
  grad.log_density = grad.log_density + value;
}

template <class T>
T density_at(const Whitened<T>& w, const Vec3<T>& mean, const Vec3<T>& x) {
  using std::exp;
  return w.density * exp(T(-0.5) * squared_length(w.matrix * (x - mean)));
}

}  // namespace vitrine
