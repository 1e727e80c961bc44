// Box-filtered coverage of a pixel by a half-plane, and its derivative by the position of the edge (Catmull 1978; algorithms
// 9.6). The pixel is the unit square about the origin, the edge {p : p.n = d} for a unit normal n that points outwards.
//   A = max(|n.x|, |n.y|)   B = min(|n.x|, |n.y|)   g = (A+B)/2   f = (A-B)/2
//   length(d) = 1/A for |d| <= f, (g-|d|)/(A B) up to |d| = g, then 0       covered(d) = integral of length up to d
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct EdgeInPixel {
  T covered{}, length{};  // of the unit square; d covered / d d
};

template <class T>
EdgeInPixel<T> edge_in_pixel(const T& d, const Vec2<T>& n) {
  const T x = n.x < T(0) ? -n.x : n.x, y = n.y < T(0) ? -n.y : n.y;
  const T a = x > y ? x : y, b = x > y ? y : x, reach = T(0.5) * (a + b), flat = T(0.5) * (a - b);
  const T away = d < T(0) ? -d : d;
  if (!(away < reach)) return {d < T(0) ? T(0) : T(1), T(0)};
  if (!(away > flat)) return {T(0.5) + d / a, T(1) / a};
  const T rest = reach - away, corner = rest * rest / (T(2) * a * b);
  return {d < T(0) ? corner : T(1) - corner, rest / (a * b)};
}

}  // namespace vitrine
