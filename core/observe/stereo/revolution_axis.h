// Rotation axis of a solid of revolution and its pattern search, shared by the fits to masks and to photo edges.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "core/foundation/math/pattern_search.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

struct TurningAxis {
  Vec3d origin, along, u, v;  // u, v: perpendicular to it, orthonormal
};
inline TurningAxis turning_axis(const Vec3d& origin, double tilt_x, double tilt_y) {
  const Vec3d along = normalized(Vec3d{tilt_x, tilt_y, 1});
  const Vec3d u = normalized(Vec3d{along.z, 0, -along.x});
  return {origin, along, u, cross(along, u)};
}

using AxisPlace = std::array<double, 4>;  // x and y of its origin, tilt towards x and y in radians

// Pattern search over the axis that maximises `score`: its origin alone or, with all four `numbers`, its tilt as well. Steps
// start at `first_move`, in units of `size` for the origin and in radians for the tilt.
template <class Score>
void improve_axis(double size, double first_move, double last_move, size_t numbers, const Score& score, AxisPlace& place) {
  static constexpr std::array<size_t, 4> kAll{0, 1, 2, 3};
  const auto move = [size](AxisPlace p, size_t i, double step) {
    p[i] += step * (i < 2 ? size : 1.0);
    return std::optional(p);
  };
  pattern_search(score, move, {first_move, last_move, true}, std::span(kAll).first(numbers), place);
}

}  // namespace vitrine
