// Common look-at point of the cameras: the point nearest to all optical axes,
//   argmin_p sum |(I - d d^T) (p - c)|^2,   c = camera centre, d = its axis
#pragma once

#include <span>

#include "core/scene/camera/view.h"

namespace vitrine {

struct LookedAt {
  Vec3d point;
  // Smallest eigenvalue of the mean of I - d d^T: 0 for parallel axes, 2/3 for axes in all directions. Near 0 the point is
  // ill-conditioned.
  double spread = 0;
};
LookedAt looked_at(std::span<const View> views);  // not empty

}  // namespace vitrine
