// Photos see angles: what stands far from the cameras moves in proportion to its distance, so that a step, or a random walk, is
// the same angle wherever it is taken.
#pragma once

#include <algorithm>
#include <cmath>

namespace vitrine {

// 1 near the cameras, whose radius is 1 around the origin; from a few radii on the distance over that.
inline float far_factor(const float* mean) {
  constexpr float kFar = 5;
  return std::max(1.f, std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]) / kFar);
}

}  // namespace vitrine
