// Surface depth of a pixel from its channels. The mean depth is smoother than the median, but at an edge it lies between two
// surfaces: if they differ by more than 1 %, the median is used.
#pragma once

#include <cmath>

namespace vitrine {

// `zdepth`: sum of w z; `alpha` > 0: sum of w; `median`: 0 if undefined.
inline float surface_depth(float zdepth, float alpha, float median) {
  constexpr float kMeanNearMedian_rel = 0.01f;
  const float mean = zdepth / alpha;
  return median > 0 && std::abs(mean - median) > kMeanNearMedian_rel * median ? median : mean;
}

}  // namespace vitrine
