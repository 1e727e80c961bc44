// How much the colour that a view sees at a pixel differs from what the other views see at the same surface point. The fit gives
// the point (its depth) and takes away what all views agree on. What is left for all of them alike says that the fit is wrong
// there (texture it is too coarse for, a depth it missed), and that much disagreement proves nothing:
//   r_v = blur(photo_v - render_v)      m = median over u of r_u(where u sees the point)      dev_v = max(0, | r_v - m | - | m |)
#pragma once

#include <vector>

#include "stages/masks/proposed/quick_fit.h"

namespace vitrine {

struct DeviationMap {
  int width = 0, height = 0;
  std::vector<float> value;  // [h,w] sRGB units, mean over a small window; NaN where too few views see the point
};
std::vector<DeviationMap> view_dependence(const std::vector<SmallPhoto>& photos, const QuickFit& fit);

}  // namespace vitrine
