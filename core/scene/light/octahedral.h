// Octahedral map of directions (Engelhardt and Dachsbacher 2008), +z at the centre: (x, y) in [-1, 1]^2 maps to the direction (x,
// y, 1 - |x| - |y|), folded outwards where z is below 0, normalised.
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

inline Vec3f octahedral_direction(float x, float y) {
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return normalized(Vec3f{x, y, z});
  return normalized(Vec3f{std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y), z});
}
inline Vec2f octahedral_place(const Vec3f& d) {
  const float s = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)), x = s * d.x, y = s * d.y;
  if (d.z >= 0) return {x, y};
  return {std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y)};
}

}  // namespace vitrine
