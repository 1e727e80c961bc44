// Rotation of a frame by a rotation vector: direction = axis, length = angle (Rodrigues' formula as a unit quaternion).
#pragma once

#include <cmath>

#include "core/foundation/math/rigid.h"

namespace vitrine {

inline constexpr double kLeastExtent_rel = 0.1;  // minimum fraction of a side left after one descent step

inline Mat3d turned_by(const Vec3d& turn, const Mat3d& axes) {
  const double angle = length(turn);
  if (!(angle > 0)) return axes;
  const Vec3d v = std::sin(0.5 * angle) / angle * turn;
  return rotation_matrix(normalized(Quatd{std::cos(0.5 * angle), v.x, v.y, v.z})) * axes;
}

}  // namespace vitrine
