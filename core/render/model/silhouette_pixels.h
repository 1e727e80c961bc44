// Silhouette pixels of known shapes (core/scene/shape), for all mirror shapes together. The silhouettes are known to a fraction
// of a pixel and give the coverage of each pixel; the derivative of the coverage by the shape parameters trains shapes on the
// silhouettes in photos (algorithms 9.6).
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/scene/camera/view.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

// Pixels within this distance of the silhouette form its band: the surfels of the shape are about that large and blur it that
// far.
inline constexpr int kSilhouetteBand = 4;

struct SilhouettePixel {
  uint32_t pixel = 0, entry = 0;  // of the set
  float covered = 0;              // by the shape, 0 to 1
  float z = 0;                    // z-depth of the shape if the pixel shows it; otherwise of the nearest part of the silhouette
  float away = 0;                 // pixels to the nearest pixel crossed by the silhouette
  Vec3f normal{};                 // of the shape, if shown: at the centre of the covered area
  bool crossed = false;           // by the silhouette; the following members are set only if true
  ShapeHit edge{};                // hit of the ray that touches the shape
  Vec3d place{};                  // position of that hit, in the world
  Vec3d grows{};                  // d covered / d place: if the surface moves by dx there, coverage changes by dot(grows, dx)
};

// For the entries of role Mirror; pixels ascending. Shapes that reach behind the camera have no silhouette.
std::vector<SilhouettePixel> silhouette_pixels(const ShapeSet& set, const View& view);

// Propagates dL/d covered of a crossed pixel to the parameters of its shape; adds to `grad`.
void silhouette_vjp(const SilhouettePixel& at, const Shape& shape, double grad_covered, std::span<double> grad);

// Box-filtered coverage of a pixel by a half-plane, and its derivative by the position of the edge (Catmull 1978; algorithms
// 9.6). The pixel is the unit square about the origin, the edge {p : p.n = d} for a unit normal n that points outwards.
//   A = max(|n.x|, |n.y|)   B = min(|n.x|, |n.y|)   g = (A+B)/2   f = (A-B)/2
//   length(d) = 1/A for |d| <= f, (g-|d|)/(A B) up to |d| = g, then 0       covered(d) = integral of length up to d
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
