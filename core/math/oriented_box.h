// A box in any position, and where rays go in and out of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "core/math/rigid.h"

namespace vitrine {

struct OrientedBox {
  // A face: at the upper or lower end of the extent along an axis.
  struct Face {
    size_t axis = 0;
    bool upper = false;
    size_t index() const { return 2 * axis + (upper ? 1 : 0); }
    bool operator==(const Face&) const = default;
  };
  static constexpr size_t kFaces = 6;
  static Face face(size_t index) { return {index / 2, index % 2 == 1}; }

  Mat3d axes;       // columns: unit vectors along the edges, right-handed
  Vec3d low, high;  // of the extent along them: a point p is inside when low <= transposed(axes) p <= high

  // Bit k of i: high along axis k.
  Vec3d corner(size_t i) const { return axes * Vec3d{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}; }
  Vec3d normal(Face f) const {  // outwards
    Vec3d n{};
    n[f.axis] = f.upper ? 1 : -1;
    return axes * n;
  }
  double offset(Face f) const { return f.upper ? high[f.axis] : -low[f.axis]; }  // dot(normal, p) of its points
  double longest_side() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }

  // To the surface; negative inside.
  double distance(const Vec3d& p) const {
    const Vec3d q = transposed_times(axes, p);
    Vec3d outside{};
    double inside = -1e300;
    for (size_t i = 0; i < 3; ++i) {
      const double d = std::max(low[i] - q[i], q[i] - high[i]);
      outside[i] = std::max(d, 0.0);
      inside = std::max(inside, d);
    }
    return inside < 0 ? inside : length(outside);
  }

  struct Crossing {
    double in, out;  // along the ray, in units of its direction
    Face entered, left;
  };
  // Of a ray that begins outside.
  std::optional<Crossing> crossing(const Vec3d& origin, const Vec3d& direction) const {
    const Vec3d o = transposed_times(axes, origin), d = transposed_times(axes, direction);
    Crossing c{0, 1e300, {}, {}};
    for (size_t i = 0; i < 3; ++i) {
      const double a = (low[i] - o[i]) / d[i], b = (high[i] - o[i]) / d[i];
      if (std::min(a, b) > c.in) c.in = std::min(a, b), c.entered = {i, d[i] < 0};
      if (std::max(a, b) < c.out) c.out = std::max(a, b), c.left = {i, d[i] > 0};
    }
    if (!(c.in > 0) || !(c.in < c.out)) return std::nullopt;
    return c;
  }
};

}  // namespace vitrine
