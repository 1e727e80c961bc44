// A rod between two points: a spout, a post.
#pragma once

#include <algorithm>

#include "core/foundation/math/vec.h"

namespace vitrine::test {

struct Rod {
  Vec3d from, to;

  Vec3d nearest(const Vec3d& p) const {
    const double t = std::clamp(dot(p - from, to - from) / dot(to - from, to - from), 0.0, 1.0);
    return from + t * (to - from);
  }
  double distance(const Vec3d& p) const { return length(p - nearest(p)); }
  // To a ray.
  double distance(const Vec3d& eye, const Vec3d& direction) const {
    double best = 1e9;
    for (int i = 0; i <= 100; ++i) {
      const Vec3d q = from + 0.01 * i * (to - from) - eye;
      best = std::min(best, length(q - dot(q, direction) / dot(direction, direction) * direction));
    }
    return best;
  }
};

}  // namespace vitrine::test
