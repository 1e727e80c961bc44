// The depth of the surface that a pixel shows, from its channels. The mean depth is smoother than the median, but at an edge it
// lies between two surfaces: where it leaves the median by more than a hundredth, the median counts.
#pragma once

#include <cmath>

namespace vitrine {

// `zdepth`: sum of w z; `alpha` > 0: sum of w; `median`: 0 where there is none.
inline float surface_depth(float zdepth, float alpha, float median) {
  constexpr float kMeanNearMedian_rel = 0.01f;
  const float mean = zdepth / alpha;
  return median > 0 && std::abs(mean - median) > kMeanNearMedian_rel * median ? median : mean;
}

}  // namespace vitrine
