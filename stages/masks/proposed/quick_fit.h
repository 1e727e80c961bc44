// A small, short, purely diffuse reconstruction: surfels whose colour is the same from every side (SH degree 0), trained for some
// hundred steps on small photos. What it cannot explain depends on the direction one looks from.
#pragma once

#include <functional>
#include <vector>

#include "core/config/describe.h"
#include "core/scene/splat_scene.h"
#include "stages/masks/small_photo.h"

namespace vitrine {

struct QuickFitConfig {
  int steps = 450;
  int max_side = 320;
  int surfels = 14000;
  int seed = 1;
};
void describe(Describer& d, QuickFitConfig& c);

struct FittedView {
  std::vector<float> srgb;    // [3,h,w]
  std::vector<float> zdepth;  // [h,w] mean depth; 0 where the surfels cover less than half
};

struct QuickFit {
  std::vector<FittedView> views;  // [view] at the size of the photos
  double l1 = 0;                  // mean absolute difference of the displayed pictures
};
QuickFit quick_fit(const QuickFitConfig& config, const MaskCapture& capture, const std::vector<SmallPhoto>& photos,
                   const std::function<void(double fraction)>& progress);

}  // namespace vitrine
