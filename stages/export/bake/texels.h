// Triangle rasterisation to texels, by texel centre. A centre on an edge belongs to the triangle on the right of the edge, on a
// horizontal edge to the one below (rows go down), so adjacent triangles share no texel.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "core/scene/image/image.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

// visit(x, y, barycentric coordinates). Corners are in texel coordinates: texel (0, 0) has its centre at (0.5, 0.5).
template <class Visit>
void for_texels_of(const Vec2f (&corner)[3], Visit&& visit) {
  Vec2d c[3];
  for (int k = 0; k < 3; ++k) c[k] = {double(corner[k].x), double(corner[k].y)};
  const auto side = [](const Vec2d& a, const Vec2d& b, const Vec2d& p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
  };
  const double area = side(c[0], c[1], c[2]);
  if (!(std::abs(area) > 1e-12)) return;
  const double sign = area > 0 ? 1 : -1;
  const int x0 = int(std::floor(std::min({c[0].x, c[1].x, c[2].x}))), x1 = int(std::floor(std::max({c[0].x, c[1].x, c[2].x})));
  const int y0 = int(std::floor(std::min({c[0].y, c[1].y, c[2].y}))), y1 = int(std::floor(std::max({c[0].y, c[1].y, c[2].y})));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2d p{x + 0.5, y + 0.5};
      double w[3];
      bool inside = true;
      for (int k = 0; k < 3 && inside; ++k) {
        const Vec2d a = c[(k + 1) % 3], b = c[(k + 2) % 3];
        w[k] = sign * side(a, b, p);
        const double dx = sign * (b.x - a.x), dy = sign * (b.y - a.y);
        inside = w[k] > 0 || (w[k] == 0 && (dy < 0 || (dy == 0 && dx > 0)));
      }
      if (inside) visit(x, y, Vec3f{float(w[0] / std::abs(area)), float(w[1] / std::abs(area)), float(w[2] / std::abs(area))});
    }
}

// Pull-push: fills unbaked texels with averages of nearby baked texels from coarser levels. Filtering and mip maps at chart
// borders then blend similar values.

// known: [h, w], nonzero where the image has a value. Without any value the result is black.
void fill_gaps(Image8& image, std::span<const uint8_t> known);

}  // namespace vitrine
