// The axis that a solid of revolution is turned about, and the search for it: shared by the fits to masks and to photos.
#pragma once

#include <array>
#include <cmath>

#include "core/math/rigid.h"

namespace vitrine {

struct TurningAxis {
  Vec3d origin, along, u, v;  // u, v: across it, orthonormal
};
inline TurningAxis turning_axis(const Vec3d& origin, double tilt_x, double tilt_y) {
  const Vec3d along = normalized(Vec3d{tilt_x, tilt_y, 1});
  const Vec3d u = normalized(Vec3d{along.z, 0, -along.x});
  return {origin, along, u, cross(along, u)};
}

using AxisPlace = std::array<double, 4>;  // x and y of its origin, tilt towards x and y in radians

// Moves the axis, its origin alone or, if all four `numbers` are free, its tilt, too, while `score` falls. Moves are of `size`
// and of radians, `first_move` of them at first.
template <class Score>
void improve_axis(double size, double first_move, double last_move, size_t numbers, const Score& score, AxisPlace& place) {
  double best = score(place);
  for (double step = first_move; step >= last_move; step *= 0.5)
    for (bool better = true; better;) {
      better = false;
      for (size_t i = 0; i < numbers; ++i)
        for (double sign : {1.0, -1.0}) {
          AxisPlace trial = place;
          trial[i] += sign * step * (i < 2 ? size : 1.0);
          if (const double s = score(trial); s < best - 1e-9 * std::abs(best)) best = s, place = trial, better = true;
        }
    }
}

}  // namespace vitrine
